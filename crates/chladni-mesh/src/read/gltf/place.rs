//! The primitives of one placed mesh, and which of their vertices are the same.

use std::collections::HashMap;
use std::ops::Range;

use super::Scene;
use super::uv_transform::Affine;

/// The vertices that the primitives of one placed mesh have brought so far.
pub(super) struct Place {
    /// The first of them among all.
    start: usize,
    /// For each of them the number that `_VERTEX` gives it; `None` once a primitive has no such attribute.
    ids: Option<Vec<f64>>,
    /// By the accessors of positions, colors and `_VERTEX`.
    known: HashMap<(usize, Option<usize>, usize), Range<u32>>,
    /// By the vertices, the accessor of their texture coordinates and where a material moves these.
    uvs: HashMap<(Range<u32>, usize, Option<Affine>), Range<usize>>,
}

impl Place {
    pub fn starting_at(start: usize) -> Self {
        Self { start, ids: Some(Vec::new()), known: HashMap::new(), uvs: HashMap::new() }
    }

    /// The vertices of an earlier primitive with these accessors. Without `_VERTEX` every primitive brings its own.
    pub fn known(&self, position: usize, color: Option<usize>, id: Option<usize>) -> Option<Range<u32>> {
        self.known.get(&(position, color, id?)).cloned()
    }

    /// Remembers `vertices`, which come after all before; `ids` is the accessor of `_VERTEX` and what it holds.
    pub fn brings(
        &mut self,
        vertices: Range<u32>,
        position: usize,
        color: Option<usize>,
        ids: Option<(usize, Vec<f64>)>,
    ) {
        match (ids, self.ids.as_mut()) {
            (Some((accessor, ids)), known) => {
                if let Some(known) = known {
                    known.extend(ids);
                }
                self.known.insert((position, color, accessor), vertices);
            }
            (None, _) => self.ids = None,
        }
    }

    /// Where the texture coordinates of these vertices lie, if an earlier primitive has brought them.
    pub fn known_uvs(
        &self,
        vertices: &Range<u32>,
        accessor: usize,
        transform: Option<Affine>,
    ) -> Option<Range<usize>> {
        self.uvs.get(&(vertices.clone(), accessor, transform)).cloned()
    }

    /// Remembers where the texture coordinates of `vertices` lie.
    pub fn brings_uvs(
        &mut self,
        vertices: &Range<u32>,
        accessor: usize,
        transform: Option<Affine>,
        points: Range<usize>,
    ) -> Range<usize> {
        self.uvs.entry((vertices.clone(), accessor, transform)).insert_entry(points).get().clone()
    }

    /// The number of vertex `v` after [`rejoin`](Scene::rejoin).
    pub fn joined(&self, v: u32) -> u32 {
        let id = self.ids.as_ref().and_then(|ids| ids.get(v as usize - self.start));
        id.map_or(v, |id| self.start as u32 + *id as u32)
    }
}

impl Scene<'_> {
    /// Merges vertices with the same id, in the order of the ids, and returns whether it did. If another program has
    /// moved some of them apart, or the ids are invalid, nothing changes.
    pub(super) fn rejoin(&mut self, place: &Place, first_corner: usize) -> bool {
        let start = place.start;
        let Some(ids) = place.ids.as_ref().filter(|ids| !ids.is_empty()) else { return false };
        let stored = &self.stored[start..];
        let mut first: Vec<Option<u32>> = vec![None; stored.len()];
        for (i, &id) in ids.iter().enumerate() {
            let Some(seen) = (id >= 0.0 && id.fract() == 0.0).then(|| first.get_mut(id as usize)).flatten()
            else {
                return false;
            };
            let known = *seen.get_or_insert(i as u32) as usize;
            if stored.get(known) != stored.get(i) {
                return false;
            }
        }
        let vertices = first.iter().take_while(|v| v.is_some()).count();
        if ids.len() != stored.len() || first[vertices..].iter().any(Option::is_some) {
            return false;
        }
        let order: Vec<usize> = first[..vertices].iter().flatten().map(|&i| start + i as usize).collect();
        let draft = &mut self.draft;
        draft.positions.splice(start.., order.iter().map(|&i| draft.positions[i]).collect::<Vec<_>>());
        if !draft.colors.is_empty() {
            draft.colors.splice(start.., order.iter().map(|&i| draft.colors[i]).collect::<Vec<_>>());
        }
        self.stored.splice(start.., order.iter().map(|&i| self.stored[i]).collect::<Vec<_>>());
        for v in &mut draft.corners[first_corner..] {
            *v = place.joined(*v);
        }
        true
    }
}
