//! Where skins place their meshes.

use std::collections::HashMap;

use super::Scene;
use crate::error::Fault;
use crate::read::gltf_json::Root;
use crate::read::gltf_matrix::{IDENTITY, Matrix, from_columns, product};

/// How far the joints of a skin at rest may disagree, as a share.
const AT_REST: f64 = 1e-3;
/// How far apart two skins may place their meshes by rounding, as a share.
const ROUNDING: f64 = 1e-5;
/// Maps with which those of further skins are compared, at most.
const MOST_MAPS: usize = 256;

/// The joints of skins.
pub(super) struct Skins {
    /// The nodes of the scene, each with its map to the scene; empty without skins.
    nodes: HashMap<usize, Matrix>,
    /// Skins of meshes so far.
    known: HashMap<usize, Bound>,
    /// The different maps to the scene so far, the identity first: only equal ones let seams between meshes weld.
    maps: Vec<Matrix>,
}

impl Skins {
    /// Those of a file whose scene has these `nodes`.
    pub fn of(root: &Root, nodes: &[(usize, Matrix)]) -> Self {
        let nodes = if root.skins.is_empty() { HashMap::new() } else { nodes.iter().copied().collect() };
        Self { nodes, known: HashMap::new(), maps: vec![IDENTITY] }
    }

    /// The earlier map that differs from `map` by rounding alone, otherwise `map` itself; `reach` as in [`agree`].
    fn without_rounding(&mut self, map: Matrix, reach: f64) -> Matrix {
        if let Some(known) = self.maps.iter().find(|known| agree(&map, known, reach, ROUNDING)) {
            return *known;
        }
        if self.maps.len() < MOST_MAPS {
            self.maps.push(map);
        }
        map
    }
}

/// What a skin says of its meshes.
#[derive(Clone, Copy)]
struct Bound {
    /// From their coordinates to the scene's, by the first joint that the scene has.
    matrix: Option<Matrix>,
    /// Whether all joints say the same, as they do at rest.
    at_rest: bool,
}

impl Scene<'_> {
    /// From the coordinates of a mesh with this skin to the scene's, if the skin has a joint there. At rest all joints
    /// place it alike; otherwise the first one does, and the pose is left out.
    pub(super) fn bound(&mut self, skin: usize, skins: &mut Skins) -> Result<Option<Matrix>, Fault> {
        let bound = match skins.known.get(&skin) {
            Some(known) => *known,
            None => {
                let found = self.by_joints(skin, skins)?;
                skins.known.insert(skin, found);
                found
            }
        };
        self.left_out.poses += usize::from(!bound.at_rest);
        Ok(bound.matrix)
    }

    fn by_joints(&self, skin: usize, skins: &mut Skins) -> Result<Bound, Fault> {
        let at = format!("skins[{skin}]");
        let Some(skin) = self.root.skins.get(skin) else {
            return Err(Fault::part(at, "there is no such skin"));
        };
        let inverse = skin.inverse_bind_matrices.map(|accessor| self.buffers.vectors::<16>(accessor, &at));
        let inverse = inverse.transpose()?.unwrap_or_default();
        let mut maps = skin.joints.iter().enumerate().filter_map(|(i, joint)| {
            let to_joint = inverse.get(i).map_or(IDENTITY, from_columns);
            Some(product(skins.nodes.get(joint)?, &to_joint))
        });
        let Some(first) = maps.next() else { return Ok(Bound { matrix: None, at_rest: false }) };
        let joints = skin.joints.iter().filter_map(|joint| skins.nodes.get(joint));
        let reach = greatest(joints.flat_map(|[.., origin]| &origin[..3]));
        let at_rest = maps.all(|map| agree(&first, &map, reach, AT_REST));
        Ok(Bound { matrix: Some(skins.without_rounding(first, reach)), at_rest })
    }
}

/// Whether two maps differ by no more than `tolerance`, as a share; `reach` is the size of the places that they lead to.
fn agree(a: &Matrix, b: &Matrix, reach: f64, tolerance: f64) -> bool {
    let size = greatest(a[..3].as_flattened());
    let near =
        |c: usize, within: f64| a[c].iter().zip(b[c]).all(|(a, b)| (a - b).abs() <= tolerance * within);
    (0..3).all(|c| near(c, size)) && near(3, size + reach)
}

fn greatest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    numbers.into_iter().fold(0.0_f64, |most, x| most.max(x.abs()))
}
