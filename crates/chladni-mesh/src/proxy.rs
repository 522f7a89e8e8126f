//! A smaller mesh that stands in for a very large one while we work on it.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::surface::vec3::{Vec3, add, cross, distance, dot, length, scaled, sub, unit};
use crate::surface::{
    Closest, SurfacePoint, TriangleTree, components, corners, doubled_area_normal, mixed, total_area,
    vertex_triangles, weld,
};
use crate::{Rows, TriMesh};

/// A mesh with some of the vertices of a larger one, and the way back: for each vertex of the large mesh the
/// point closest to it on its own piece of the small surface, or on all of it where nothing is left of that piece.
#[derive(Clone, Debug)]
pub struct Proxy {
    whole: Arc<TriMesh>,
    mesh: Arc<TriMesh>,
    /// For each vertex of `mesh` the vertex of `whole` that it is.
    whole_vertex: Vec<u32>,
    /// For each vertex of `whole` its place on `mesh`; `None` where no triangle uses it.
    on_proxy: Vec<Option<SurfacePoint>>,
    farthest: f64,
}

/// How far detail may swell or shrink with the surface that carries it; as many times more where the whole surface
/// grows, or shrinks.
const SWELLING: [f64; 2] = [0.25, 4.0];

/// The largest share of vertices that may lie in pieces that vanish from the proxy.
#[cfg(feature = "simplify")]
const MOST_LOST: f64 = 0.01;

impl Proxy {
    /// `whole` with about as many `vertices`, or `None` where it has less than twice as many, or cannot have so few
    /// and keep its pieces: of small ones, with a hundredth of the vertices together, nothing may be left. Positions
    /// are those of the file, bit for bit; vertex colors and attributes come along, textures and polygons do
    /// not. Coincident vertices are one.
    ///
    /// Vertices are collapsed into neighbors, the one that changes the surface least first
    /// ([`details`](crate::surface::details)). Deterministic on one machine; the arithmetic is in 32 bits, so that
    /// another kind of processor may choose a few other vertices.
    #[cfg(feature = "simplify")]
    pub fn of(whole: &Arc<TriMesh>, vertices: usize) -> Option<Self> {
        let welded = weld(whole);
        if welded.positions.len() < 2 * vertices {
            return None;
        }
        let frame = crate::Frame::of_welded(whole, &welded.operator_vertex);
        let rest: Vec<[f32; 3]> =
            welded.positions.par_iter().map(|p| frame.to_working(*p).map(|c| c as f32)).collect();
        let detail = crate::surface::details(&rest, &welded.triangles, &[vertices]).pop()?;
        let piece = components(welded.positions.len(), &welded.triangles);
        // Where triangles share few vertices they are few for as many.
        if detail.vertices > 2 * vertices
            || lost(&piece, &detail.triangles) > MOST_LOST * welded.positions.len() as f64
        {
            return None;
        }
        let mut file_vertex = vec![u32::MAX; welded.positions.len()];
        for (v, operator_vertex) in (0..).zip(&welded.operator_vertex) {
            if let Some(place) = operator_vertex.and_then(|o| file_vertex.get_mut(o as usize)) {
                *place = v.min(*place);
            }
        }
        let triangles: Vec<[u32; 3]> =
            detail.triangles.iter().map(|t| t.map(|v| file_vertex[v as usize])).collect();
        Some(Self::between(whole, &triangles, &welded.operator_vertex, &piece))
    }

    /// The proxy with these `triangles` over vertices of `whole`, from whatever simplifies.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn over(whole: &Arc<TriMesh>, triangles: &[[u32; 3]]) -> Self {
        let welded = weld(whole);
        let of = |v: u32| welded.operator_vertex[v as usize];
        // Pieces that the given triangles join are one.
        let joining = triangles.iter().filter_map(|[a, b, c]| Some([of(*a)?, of(*b)?, of(*c)?]));
        let joined: Vec<[u32; 3]> = welded.triangles.iter().copied().chain(joining).collect();
        let piece = components(welded.positions.len(), &joined);
        Self::between(whole, triangles, &welded.operator_vertex, &piece)
    }

    /// The proxy with these `triangles` over vertices of `whole`, whose [`weld`] has this `operator_vertex`; `piece` is the
    /// component of each vertex of that.
    fn between(
        whole: &Arc<TriMesh>,
        triangles: &[[u32; 3]],
        operator_vertex: &[Option<u32>],
        piece: &[u32],
    ) -> Self {
        let mut used = vec![false; whole.positions.len()];
        triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let whole_vertex: Vec<u32> = (0..).zip(&used).filter(|(_, used)| **used).map(|(v, _)| v).collect();
        let mut row = vec![u32::MAX; whole.positions.len()];
        (0..).zip(&whole_vertex).for_each(|(new, old)| row[*old as usize] = new);
        let triangles = triangles.iter().map(|t| t.map(|v| row[v as usize])).collect();
        let mesh = chosen(whole, &whole_vertex, triangles);
        let piece_of = |v: u32| operator_vertex[whole_vertex[v as usize] as usize].map(|o| piece[o as usize]);
        let trees = PieceTrees::new(&mesh, piece_of);
        // The vertices that the operator has are those of the surface: by place, and none of a collapsed triangle alone.
        let on_surface =
            |(p, seen): (&Vec3, &Option<u32>)| seen.and_then(|o| trees.closest(*p, piece[o as usize]));
        let closest: Vec<_> = whole.positions.par_iter().zip(operator_vertex).map(on_surface).collect();
        let farthest =
            closest.par_iter().flatten().map(|c| c.distance_squared).reduce(|| 0.0, f64::max).sqrt();
        let on_proxy = closest.into_par_iter().map(|c| c.map(|c| c.on)).collect();
        Self { whole: Arc::clone(whole), mesh: Arc::new(mesh), whole_vertex, on_proxy, farthest }
    }

    /// The large mesh.
    pub fn whole(&self) -> &Arc<TriMesh> {
        &self.whole
    }

    /// The small mesh.
    pub fn mesh(&self) -> &Arc<TriMesh> {
        &self.mesh
    }

    /// For each vertex of the small mesh the vertex of the large one that it is, ascending.
    pub fn whole_vertex(&self) -> &[u32] {
        &self.whole_vertex
    }

    /// How far the large mesh lies from the small surface at most, in file units.
    pub fn farthest(&self) -> f64 {
        self.farthest
    }

    /// The displacements of the large mesh's n vertices where those of the small one are `displacements`, both in
    /// file units.
    ///
    /// Around each vertex of the small mesh the movement is read as an affine map: least squares over its
    /// edges, and along the normal as the normal turns and the surface swells. A vertex of the large mesh moves
    /// as the three maps of its triangle say, by their barycentric weights, so that detail which the small
    /// mesh lacks turns and grows with what carries it. Turning, shifting and scaling all are carried exactly,
    /// and so is rest.
    ///
    /// # Panics
    /// If there are not as many displacements as vertices.
    pub fn carried(&self, displacements: &[Vec3]) -> Vec<Vec3> {
        let small = &*self.mesh;
        let moved: Vec<Vec3> = small.positions.iter().zip(displacements).map(|(p, d)| add(*p, *d)).collect();
        let around = vertex_triangles(small.positions.len(), &small.triangles);
        let [before, after] = [&small.positions, &moved].map(|at| total_area(at, &small.triangles));
        let growth = Some((after / before).sqrt()).filter(|g| *g > 0.0 && g.is_finite()).unwrap_or(1.0);
        let swellings = [SWELLING[0] * growth.min(1.0), SWELLING[1] * growth.max(1.0)];
        let maps: Vec<Affine> = (0..small.positions.len())
            .into_par_iter()
            .map(|v| Affine::around(v, small, &moved, displacements[v], &around, swellings))
            .collect();
        let of = |(p, on): (&Vec3, &Option<SurfacePoint>)| {
            let Some(on) = on else { return [0.0; 3] };
            let triangle = small.triangles[on.triangle as usize];
            mixed(triangle.map(|v| maps[v as usize].displacement(*p)), on.weights)
        };
        self.whole.positions.par_iter().zip(&self.on_proxy).map(of).collect()
    }

    /// Numbers at the small mesh's vertices, on the large one's; 0 where no triangle uses a vertex.
    ///
    /// # Panics
    /// If there are not as many values as vertices.
    pub fn spread(&self, values: &[f32]) -> Vec<f32> {
        let of = |on: &Option<SurfacePoint>| {
            let Some(on) = on else { return 0.0 };
            let triangle = self.mesh.triangles[on.triangle as usize];
            triangle.iter().zip(on.weights).map(|(v, w)| f64::from(values[*v as usize]) * w).sum::<f64>()
                as f32
        };
        self.on_proxy.par_iter().map(of).collect()
    }

    /// The vertex of the small mesh nearest to a vertex of the large one; `None` where there is none.
    pub fn nearest(&self, whole_vertex: u32) -> Option<u32> {
        let on = (*self.on_proxy.get(whole_vertex as usize)?)?;
        let triangle = self.mesh.triangles.get(on.triangle as usize)?;
        let place = self.whole.positions.get(whole_vertex as usize)?;
        let away = |v: &u32| distance(self.mesh.positions[*v as usize], *place);
        triangle.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)))
    }
}

/// A tree over the triangles of each piece of a mesh, and one over all of them: where pieces touch, none takes along what
/// lies on another.
struct PieceTrees<'a> {
    mesh: &'a TriMesh,
    /// Only vertices of pieces that have no triangles left need it.
    all: OnceLock<TriangleTree>,
    /// For each piece that has triangles its tree, and which of the mesh's triangles its own are.
    of_piece: HashMap<u32, (TriangleTree, Vec<u32>)>,
}

impl<'a> PieceTrees<'a> {
    /// `piece_of` says to which piece a vertex of `mesh` belongs.
    fn new(mesh: &'a TriMesh, piece_of: impl Fn(u32) -> Option<u32>) -> Self {
        let mut members: HashMap<u32, Vec<u32>> = HashMap::new();
        for (t, [v, ..]) in (0..).zip(&mesh.triangles) {
            if let Some(piece) = piece_of(*v) {
                members.entry(piece).or_default().push(t);
            }
        }
        let with_tree = |(piece, members): (u32, Vec<u32>)| {
            let own: Vec<[u32; 3]> = members.iter().map(|t| mesh.triangles[*t as usize]).collect();
            (piece, (TriangleTree::new(&mesh.positions, &own), members))
        };
        Self { mesh, all: OnceLock::new(), of_piece: members.into_iter().map(with_tree).collect() }
    }

    /// The point of `piece` closest to `place`, or of all where it has no triangle.
    fn closest(&self, place: Vec3, piece: u32) -> Option<Closest> {
        let Some((tree, members)) = self.of_piece.get(&piece) else {
            let all = || TriangleTree::new(&self.mesh.positions, &self.mesh.triangles);
            return self.all.get_or_init(all).closest(place, f64::INFINITY);
        };
        let closest = tree.closest(place, f64::INFINITY)?;
        let triangle = members[closest.on.triangle as usize];
        Some(Closest { on: SurfacePoint { triangle, ..closest.on }, ..closest })
    }
}

/// Number of vertices in pieces that are missing from `triangles`, where `piece` is that of each vertex.
#[cfg(feature = "simplify")]
fn lost(piece: &[u32], triangles: &[[u32; 3]]) -> f64 {
    let mut is_kept = vec![false; piece.len()];
    triangles.iter().flatten().for_each(|v| is_kept[piece[*v as usize] as usize] = true);
    piece.iter().filter(|p| !is_kept[**p as usize]).count() as f64
}

/// The vertices `chosen` of `whole` under `triangles`.
fn chosen(whole: &TriMesh, chosen: &[u32], triangles: Vec<[u32; 3]>) -> TriMesh {
    let of = |v: &u32| *v as usize;
    let colors = whole.appearance.colors.as_ref();
    let attribute = |all: &crate::Attribute| crate::Attribute {
        name: all.name.clone(),
        values: chosen.iter().map(|v| all.values[of(v)]).collect(),
    };
    let appearance = crate::Appearance {
        colors: colors.map(|colors| chosen.iter().map(|v| colors[of(v)]).collect()),
        colors_tint: whole.appearance.colors_tint,
        attributes: whole.appearance.attributes.iter().map(attribute).collect(),
        ..crate::Appearance::default()
    };
    TriMesh { positions: chosen.iter().map(|v| whole.positions[of(v)]).collect(), triangles, appearance }
}

/// x ↦ d + G (x − c): how the surroundings of a vertex at c move.
struct Affine {
    center: Vec3,
    displacement: Vec3,
    /// By rows.
    gradient: [Vec3; 3],
}

impl Affine {
    /// Around vertex `v` of `mesh`, whose vertices go to `moved`; `low` and `high` limit how its surface swells.
    fn around(
        v: usize,
        mesh: &TriMesh,
        moved: &[Vec3],
        displacement: Vec3,
        around: &Rows,
        [low, high]: [f64; 2],
    ) -> Self {
        let center = mesh.positions[v];
        let (mut normals, mut areas, mut edges) = ([[0.0; 3]; 2], [0.0; 2], 0.0);
        // Σ e eᵀ and Σ Δd eᵀ over unit edges e.
        let (mut squares, mut products) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for &t in around.row(v) {
            let triangle = &mesh.triangles[t as usize];
            for (i, at) in [&mesh.positions[..], moved].into_iter().enumerate() {
                let normal = doubled_area_normal(corners(at, triangle));
                normals[i] = add(normals[i], normal);
                areas[i] += length(normal);
            }
            for &w in triangle.iter().filter(|w| **w as usize != v) {
                let edge = sub(mesh.positions[w as usize], center);
                let change = sub(sub(moved[w as usize], moved[v]), edge);
                let inverse_square = 1.0 / dot(edge, edge);
                if inverse_square.is_finite() {
                    add_product(&mut squares, edge, edge, inverse_square);
                    add_product(&mut products, change, edge, inverse_square);
                    edges += 1.0;
                }
            }
        }
        let [before, after] = normals.map(unit);
        let swelling = (areas[1] / areas[0]).sqrt().clamp(low, high);
        if swelling.is_finite() {
            add_product(&mut squares, before, before, edges);
            add_product(&mut products, sub(scaled(after, swelling), before), before, edges);
        }
        let gradient = quotient(products, squares).unwrap_or_default();
        Self { center, displacement, gradient }
    }

    fn displacement(&self, at: Vec3) -> Vec3 {
        let off = sub(at, self.center);
        add(self.displacement, self.gradient.map(|row| dot(row, off)))
    }
}

/// M += s a bᵀ.
fn add_product(matrix: &mut [Vec3; 3], a: Vec3, b: Vec3, s: f64) {
    for (row, x) in matrix.iter_mut().zip(a) {
        *row = add(*row, scaled(b, s * x));
    }
}

/// P S⁻¹ of a symmetric S; `None` where S is nearly singular.
fn quotient(p: [Vec3; 3], s: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let cofactors = [cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])];
    let determinant = dot(s[0], cofactors[0]);
    let size = s[0][0] + s[1][1] + s[2][2];
    if determinant.abs() <= 1e-9 * size.powi(3) {
        return None;
    }
    // S⁻¹ is symmetric, too: its columns are its rows.
    Some(p.map(|row| cofactors.map(|c| dot(row, c) / determinant)))
}

#[cfg(all(test, feature = "simplify"))]
mod tests {
    use super::*;
    use crate::{Attribute, samples};

    /// A ball with bumps, of 40,962 vertices, off the origin; `quality` is its height.
    fn scan() -> Arc<TriMesh> {
        let mut mesh = samples::icosphere(6);
        for p in &mut mesh.positions {
            let bump = 1.0 + 0.1 * (9.0 * p[0]).sin() * (7.0 * p[1]).cos();
            *p = [30.0 * bump * p[0] + 100.0, 30.0 * bump * p[1], 40.0 * bump * p[2]];
        }
        let values = mesh.positions.iter().map(|p| p[2]).collect();
        mesh.appearance.attributes = vec![Attribute { name: "quality".into(), values }];
        Arc::new(mesh)
    }

    fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
    }

    #[test]
    fn a_proxy_has_some_of_the_vertices_and_lies_near() {
        let scan = scan();
        let proxy = Proxy::of(&scan, 3000).unwrap();
        let mesh = proxy.mesh();
        assert_eq!(mesh.positions.len(), 3000);
        for (v, whole) in proxy.whole_vertex().iter().enumerate() {
            let whole_vertex = *whole as usize;
            assert_eq!(mesh.positions[v], scan.positions[whole_vertex]);
            assert_eq!(mesh.appearance.attributes[0].values[v], scan.positions[whole_vertex][2]);
            assert_eq!(proxy.nearest(*whole), Some(v as u32));
        }
        // Edges are about 3.5 long where the surface's radius of curvature is some 5 at least.
        assert!((0.01..0.5).contains(&proxy.farthest()), "{}", proxy.farthest());
        let tree = TriangleTree::new(&mesh.positions, &mesh.triangles);
        let away = scan.positions.iter().map(|p| tree.closest(*p, f64::INFINITY).unwrap().distance_squared);
        assert_eq!(away.fold(0.0, f64::max).sqrt(), proxy.farthest());
        assert_eq!(proxy.mesh().triangles, Proxy::of(&scan, 3000).unwrap().mesh().triangles);
        assert!(Proxy::of(&scan, 30_000).is_none());
    }

    #[test]
    fn turning_shifting_and_scaling_all_is_carried_exactly_and_so_is_rest() {
        let scan = scan();
        let proxy = Proxy::of(&scan, 3000).unwrap();
        let (sin, cos) = 0.7_f64.sin_cos();
        for scale in [0.1, 1.3, 9.0] {
            let moved = |p: &Vec3| {
                let [x, y, z] = p.map(|c| scale * c);
                sub([cos * x - sin * y + 5.0, sin * x + cos * y, z - 3.0], *p)
            };
            let small: Vec<Vec3> = proxy.mesh().positions.iter().map(moved).collect();
            let expected: Vec<Vec3> = scan.positions.iter().map(moved).collect();
            let off = farthest(&proxy.carried(&small), &expected);
            assert!(off < 1e-9, "{scale}: {off}");
        }
        let rest = vec![[0.0; 3]; proxy.mesh().positions.len()];
        assert!(proxy.carried(&rest).iter().all(|d| *d == [0.0; 3]));
        // What rests does so however far the other half grows.
        let grows = |p: &Vec3| if p[2] > 0.0 { p.map(|c| 9.0 * c) } else { [0.0; 3] };
        let half: Vec<Vec3> = proxy.mesh().positions.iter().map(grows).collect();
        let carried = proxy.carried(&half);
        let far_below = scan.positions.iter().zip(&carried).filter(|(p, _)| p[2] < -10.0);
        assert!(far_below.clone().count() > 1000 && far_below.clone().all(|(_, d)| *d == [0.0; 3]));
    }

    #[test]
    fn a_copy_that_only_a_collapsed_triangle_uses_moves_along_and_one_far_away_rests() {
        let mut scan = TriMesh::clone(&scan());
        let n = scan.positions.len() as u32;
        let [a, b] = [scan.triangles[0][0], scan.triangles[0][1]];
        scan.positions.extend([scan.positions[a as usize], [1e3, 0.0, 0.0]]);
        scan.triangles.extend([[a, n, b], [n + 1; 3]]);
        scan.appearance.attributes.clear();
        let proxy = Proxy::of(&Arc::new(scan), 3000).unwrap();
        let up = vec![[0.0, 0.0, 2.0]; proxy.mesh().positions.len()];
        let carried = proxy.carried(&up);
        assert!(distance(carried[n as usize], carried[a as usize]) < 1e-9 && carried[n as usize][2] > 1.9);
        assert_eq!(carried[n as usize + 1], [0.0; 3]);
        assert!(proxy.farthest() < 1.0, "{}", proxy.farthest());
    }

    #[test]
    fn pieces_that_touch_move_each_by_itself() {
        // Two squares in one plane that overlap in a quarter of each.
        let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]];
        let places = [square(0.0, 2.0), square(1.0, 3.0)].into_iter().flatten();
        let whole = Arc::new(TriMesh {
            positions: places.map(|[x, y]| [x, y, 0.0]).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..TriMesh::default()
        });
        let proxy = Proxy::over(&whole, &whole.triangles);
        assert!((0..8).all(|v| proxy.nearest(v) == Some(v)));
        let displacements: Vec<Vec3> = (0..8).map(|v| [0.0, 0.0, f64::from(u8::from(v < 4))]).collect();
        assert!(farthest(&proxy.carried(&displacements), &displacements) < 1e-9);
        // Of a piece that vanishes the vertices go with what is left.
        let first_alone = Proxy::over(&whole, &whole.triangles[..2]);
        assert!((4..8).all(|v| first_alone.nearest(v).is_some_and(|v| v < 4)));
    }

    #[test]
    fn a_smooth_movement_is_carried_and_keeps_its_place_at_the_vertices_of_the_proxy() {
        let scan = scan();
        let proxy = Proxy::of(&scan, 3000).unwrap();
        let moved = |p: &Vec3| [0.0, 6.0 * (p[0] / 15.0).sin(), 4.0 * (p[2] / 12.0).cos()];
        let small: Vec<Vec3> = proxy.mesh().positions.iter().map(moved).collect();
        let carried = proxy.carried(&small);
        for (v, whole) in proxy.whole_vertex().iter().enumerate() {
            assert!(distance(carried[*whole as usize], small[v]) < 1e-9);
        }
        // Second differences: at most 6/15² and 4/12² times half the square of an edge's length, some 3.5; and how
        // the normal's own direction is guessed, over what the surface lies away.
        let expected: Vec<Vec3> = scan.positions.iter().map(moved).collect();
        let off = farthest(&carried, &expected);
        assert!(off < 0.4, "{off}");
        let mean =
            carried.iter().zip(&expected).map(|(a, b)| distance(*a, *b)).sum::<f64>() / carried.len() as f64;
        assert!(mean < 0.03, "{mean}");
    }

    #[test]
    fn seams_and_loose_vertices_of_the_scan_follow() {
        // Every triangle has its own corners, as in an STL, and one vertex has none.
        let closed = scan();
        let positions: Vec<Vec3> =
            closed.triangles.iter().flatten().map(|v| closed.positions[*v as usize]).collect();
        let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut soup = TriMesh { positions, triangles, ..TriMesh::default() };
        soup.positions.push([1e3; 3]);
        let soup = Arc::new(soup);
        let proxy = Proxy::of(&soup, 3000).unwrap();
        assert_eq!(proxy.mesh().positions.len(), 3000);
        let ones = vec![[1.0, 2.0, 3.0]; 3000];
        let carried = proxy.carried(&ones);
        assert_eq!(carried.last(), Some(&[0.0; 3]));
        assert!(farthest(&carried[..carried.len() - 1], &vec![[1.0, 2.0, 3.0]; carried.len() - 1]) < 1e-9);
        let spread = proxy.spread(&vec![0.5; 3000]);
        assert!(
            spread[..spread.len() - 1].iter().all(|x| (x - 0.5).abs() < 1e-6) && spread.last() == Some(&0.0)
        );
        assert_eq!((proxy.nearest(soup.positions.len() as u32 - 1), proxy.nearest(u32::MAX)), (None, None));
        assert_eq!(weld(proxy.mesh()).positions.len(), 3000);
    }
}
