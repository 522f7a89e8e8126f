//! Bending a shape onto a template: non-rigid ICP in the manner of Amberg, Romdhani and Vetter
//! (*Optimal Step Nonrigid ICP*, CVPR 2007), with the affine maps on a graph that gets finer
//! while the stiffness falls.

use chladni_task::Task;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, Triplet};
use glam::DVec3;
use rayon::prelude::*;

use crate::graph::{Graph, NodeMap};
use crate::landmarks::Pinned;
use crate::partners::Partners;
use crate::surface::UnitSurface;
use crate::{MatchError, Similarity};

/// One graph: its nodes, and the stiffness and reach at its first and last iteration.
struct Coarseness {
    nodes: usize,
    iterations: usize,
    stiffness: (f64, f64),
    reach: (f64, f64),
}

const LEVELS: [Coarseness; 3] = [
    Coarseness { nodes: 100, iterations: 10, stiffness: (10.0, 0.3), reach: (0.10, 0.06) },
    Coarseness { nodes: 400, iterations: 8, stiffness: (1.0, 0.1), reach: (0.06, 0.04) },
    Coarseness { nodes: 1500, iterations: 6, stiffness: (0.3, 0.05), reach: (0.04, 0.03) },
];

/// Vertices whose distances are minimized.
const DATA_VERTICES: usize = 6000;
/// The weight that draws each map toward the identity; it decides where there is no data.
const IDENTITY_WEIGHT: f64 = 1e-3;
/// Cosine below which two normals are taken to belong to different sides.
const NORMAL_LIMIT: f64 = 0.4;

/// The target of a vertex: a point in the shape's coordinates and a weight in [0, 1].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    pub vertex: u32,
    pub to: DVec3,
    pub weight: f64,
}

/// The shape's vertices, bent onto the aligned template, in the coordinates of the shape's surface. Progress is that of a
/// stage called `stage`.
pub(crate) fn bend(
    shape: &UnitSurface,
    template: &UnitSurface,
    pose: &Similarity,
    landmarks: &[Pinned],
    seed: u64,
    (stage, task): (&str, &Task),
) -> Result<Vec<DVec3>, MatchError> {
    let mut bent = shape.points.clone();
    let vertices = data_vertices(shape, seed);
    let stage = task.stage(stage, LEVELS.iter().map(|l| l.iterations as u64).sum());
    for level in &LEVELS {
        let graph = Graph::new(shape, level.nodes.min(shape.points.len()), seed, task)?;
        let partners = Partners::by_vote(shape, template, pose, &bent);
        for step in 0..level.iterations {
            task.check()?;
            let along = step as f64 / (level.iterations - 1) as f64;
            let between = |(a, b): (f64, f64)| a * (b / a).powf(along);
            let normals = shape.normals_at(&bent);
            let mut pulls = pulls(shape, &partners, pose, &vertices, &bent, &normals, between(level.reach));
            let weight = 0.02 * vertices.len() as f64;
            pulls.extend(landmarks.iter().map(|l| Pull {
                vertex: l.shape,
                to: pose.at(template.points[l.template as usize]),
                weight,
            }));
            let maps = solve(shape, &graph, &pulls, vertices.len() as f64, between(level.stiffness))?;
            bent = graph.apply(shape, &maps);
            stage.advance(1);
        }
    }
    Ok(bent)
}

/// Vertices spread evenly by area; all vertices if there are few.
fn data_vertices(shape: &UnitSurface, seed: u64) -> Vec<u32> {
    let n = shape.points.len();
    if n <= DATA_VERTICES {
        return (0..n as u32).collect();
    }
    // The nodes of a fine graph are evenly spread over the surface.
    Graph::nodes_only(shape, DATA_VERTICES, seed ^ 1)
}

/// The target of each data vertex; a vertex without a target has weight 0.
pub(crate) fn pulls(
    shape: &UnitSurface,
    partners: &Partners,
    pose: &Similarity,
    vertices: &[u32],
    bent: &[DVec3],
    normals: &[DVec3],
    reach: f64,
) -> Vec<Pull> {
    let back = pose.inverse();
    let turn = back.rotation_matrix();
    let template = partners.template;
    vertices
        .par_iter()
        .filter_map(|&vertex| {
            let normal = turn * normals[vertex as usize];
            let at =
                partners.nearest(shape.component[vertex as usize], back.at(bent[vertex as usize]), normal)?;
            let facing = template.smooth_normal(&at.on).dot(normal);
            if facing < NORMAL_LIMIT || template.on_boundary(&at.on) {
                return None;
            }
            let d2 = at.distance_squared * pose.scale * pose.scale;
            let c2 = reach * reach;
            Some(Pull {
                vertex,
                to: pose.at(DVec3::from_array(at.point)),
                weight: facing * (c2 / (c2 + d2)).powi(2),
            })
        })
        .collect()
}

/// The lower triangle of a symmetric matrix under construction, as dense 4×4 blocks.
struct Blocks {
    blocks: std::collections::HashMap<(u32, u32), [[f64; 4]; 4]>,
}

impl Blocks {
    /// Adds w (rowᵢ·Xᵢ + rowⱼ·Xⱼ + …)².
    fn add(&mut self, row: &[(u32, [f64; 4])], w: f64) {
        for (i, a) in row {
            for (j, b) in row {
                if j > i {
                    continue;
                }
                let block = self.blocks.entry((*i, *j)).or_insert([[0.0; 4]; 4]);
                for r in 0..4 {
                    for c in 0..4 {
                        block[r][c] += w * a[r] * b[c];
                    }
                }
            }
        }
    }
}

/// The maps that minimize
/// mean w‖y(v) − c(v)‖² + α mean‖map_i(g_j) − map_j(g_j)‖² + α h² mean‖A_i − A_j‖² + ε h²‖A − I‖².
///
/// The three coordinates share one matrix; the unknowns are the differences from the identity.
fn solve(
    shape: &UnitSurface,
    graph: &Graph,
    pulls: &[Pull],
    data: f64,
    stiffness: f64,
) -> Result<Vec<NodeMap>, MatchError> {
    let n = graph.nodes.len();
    let g = |j: u32| shape.points[graph.nodes[j as usize] as usize];
    let mut matrix = Blocks { blocks: std::collections::HashMap::new() };
    let mut right = faer::Mat::<f64>::zeros(4 * n, 3);
    for pull in pulls {
        let x = shape.points[pull.vertex as usize];
        let row: Vec<(u32, [f64; 4])> = graph.blend[pull.vertex as usize]
            .iter()
            .map(|(j, b)| {
                let d = (x - g(*j)) * *b;
                (*j, [d.x, d.y, d.z, *b])
            })
            .collect();
        let w = pull.weight / data;
        matrix.add(&row, w);
        let wanted = (pull.to - x) * w;
        for (j, a) in &row {
            for r in 0..4 {
                for c in 0..3 {
                    right[(4 * *j as usize + r, c)] += a[r] * wanted[c];
                }
            }
        }
    }
    let h = graph.spacing;
    let smooth = stiffness / graph.edges.len().max(1) as f64;
    for &(i, j, w) in &graph.edges {
        let d = g(j) - g(i);
        // The two maps should agree on each other's node, and on A.
        matrix.add(&[(i, [d.x, d.y, d.z, 1.0]), (j, [0.0, 0.0, 0.0, -1.0])], smooth * w);
        matrix.add(&[(j, [-d.x, -d.y, -d.z, 1.0]), (i, [0.0, 0.0, 0.0, -1.0])], smooth * w);
        for k in 0..3 {
            let mut e = [0.0; 4];
            e[k] = h;
            matrix.add(&[(i, e), (j, e.map(|x| -x))], smooth * w);
        }
    }
    for j in 0..n as u32 {
        for k in 0..4 {
            let mut e = [0.0; 4];
            e[k] = if k < 3 { h } else { 1e-3 };
            matrix.add(&[(j, e)], IDENTITY_WEIGHT / n as f64);
        }
    }
    let mut triplets = Vec::with_capacity(matrix.blocks.len() * 16);
    for ((i, j), block) in &matrix.blocks {
        for r in 0..4 {
            for c in 0..4 {
                let (row, column) = (4 * *i as usize + r, 4 * *j as usize + c);
                if row >= column {
                    triplets.push(Triplet::new(row, column, block[r][c]));
                }
            }
        }
    }
    let failed = MatchError::Solver("bending");
    let matrix = SparseColMat::try_new_from_triplets(4 * n, 4 * n, &triplets).map_err(|_| failed.clone())?;
    let x = solved(&matrix, right).ok_or(failed)?;
    let maps: Vec<NodeMap> = (0..n)
        .map(|j| {
            std::array::from_fn(|c| {
                std::array::from_fn(|r| x[(4 * j + r, c)] + if r == c { 1.0 } else { 0.0 })
            })
        })
        .collect();
    if maps.iter().flatten().flatten().all(|x| x.is_finite()) {
        Ok(maps)
    } else {
        Err(MatchError::Solver("bending"))
    }
}

/// The solution of a symmetric positive definite system of which `lower` is the lower triangle.
///
/// On one thread: faer's parallel factorization waits by spinning, which costs more than it gains at this
/// size, and far more when other work shares the processor.
fn solved(lower: &SparseColMat<usize, f64>, mut right: faer::Mat<f64>) -> Option<faer::Mat<f64>> {
    let (side, par) = (faer::Side::Lower, faer::Par::Seq);
    let symbolic =
        factorize_symbolic_cholesky(lower.symbolic(), side, SymmetricOrdering::Amd, Default::default())
            .ok()?;
    let scratch = StackReq::or(
        symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default()),
        symbolic.solve_in_place_scratch::<f64>(right.ncols(), par),
    );
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    let mut values = vec![0.0; symbolic.len_val()];
    let factor = symbolic
        .factorize_numeric_llt(
            &mut values,
            lower.as_ref(),
            side,
            Default::default(),
            par,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .ok()?;
    factor.solve_in_place_with_conj(faer::Conj::No, right.as_mut(), par, MemStack::new(&mut memory));
    Some(right)
}
