//! Which triangles face inward.

use super::adjacency::sorted_half_edges;
use super::vec3::{Vec3, add, dot, length, scaled, sub};
use super::{Bounds, BoxTree, TriangleTree, components, corners, doubled_area_normal, mixed, vertex_normals};

/// A component faces outward or inward if its volume is at least this share of area^1.5, of which a ball has 0.094. Less
/// may be rounding.
const CLOSED: f64 = 1e-9;
/// The same for one with open edges, whose inside may be in doubt: a dish as deep as a tenth of its radius has as much.
const OPEN: f64 = 0.01;
/// Points of a component, at most, that are asked whether they lie within another one.
const ASKED: usize = 16;
/// Components, at most, of which one is asked whether it lies within them; so the time grows with the number of triangles
/// only, whatever overlaps.
const AROUND: usize = 16;

/// For each of `triangles` whether turning it round helps all of them to face outward.
///
/// First, triangles that share an edge with one other are made to agree: those of the lesser area are turned if more edges
/// disagree than they have open ones (pieces that merely touch keep their winding). On a surface with one side none is
/// turned.
/// Then a component is turned as a whole if its volume is negative: the volume of the cone from the surface to a point,
/// for an open component from every one of its vertices. One that is too flat to have an inside keeps its winding. What
/// lies within another component is turned if that is: the walls of a cavity face inward and should.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn inward_triangles(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<bool> {
    let (links, rims) = touching(triangles);
    let area = |t: usize| 0.5 * length(doubled_area_normal(corners(positions, &triangles[t])));
    let (mut turned, one_sided) = against_most(triangles.len(), area, &links, &rims);
    let even = turned_round(triangles, &turned);
    let surface = Surface { positions, triangles: &even };
    let parts = surface.parts(&rims, &one_sided);
    if parts.iter().any(|part| part.inward == Some(true)) {
        for (part, turn) in parts.iter().zip(surface.turns(&parts)) {
            part.triangles.iter().for_each(|t| turned[*t as usize] ^= turn);
        }
    }
    turned
}

/// `triangles`, those that face inward turned round: some programs write shapes inside out, and there a bump would be a
/// hollow.
///
/// # Panics
/// As [`inward_triangles`].
pub fn facing_outward(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    turned_round(triangles, &inward_triangles(positions, triangles))
}

fn turned_round(triangles: &[[u32; 3]], turned: &[bool]) -> Vec<[u32; 3]> {
    let all = triangles.iter().zip(turned);
    all.map(|(&[a, b, c], turned)| if *turned { [a, c, b] } else { [a, b, c] }).collect()
}

/// Two triangles with an edge of their own, and whether both have the same side up.
type Link = (u32, u32, bool);

/// The links of all triangles, and the triangle of each edge that has one only.
fn touching(triangles: &[[u32; 3]]) -> (Vec<Link>, Vec<u32>) {
    let (mut links, mut rims) = (Vec::new(), Vec::new());
    let sorted = |t: u32| {
        let mut corners = triangles[t as usize];
        corners.sort_unstable();
        corners
    };
    for edge in sorted_half_edges(triangles.iter().map(|t| &t[..])).chunk_by(|a, b| a.ends == b.ends) {
        match edge {
            [only] => rims.push(only.face),
            // The rim of what the file has twice.
            [a, b] if a.forward == b.forward && sorted(a.face) == sorted(b.face) => {
                rims.extend([a.face, b.face]);
            }
            [a, b] => links.push((a.face, b.face, a.forward != b.forward)),
            _ => {}
        }
    }
    (links, rims)
}

/// For each triangle whether it runs against the larger area of what it is linked with, and does so with its like along
/// most of their border; and a triangle of each surface with one side. `rims` are the triangles of open edges.
fn against_most(
    count: usize,
    area: impl Fn(usize) -> f64,
    links: &[Link],
    rims: &[u32],
) -> (Vec<bool>, Vec<u32>) {
    let (mut turned, mut one_sided) = (vec![false; count], Vec::new());
    if links.iter().all(|(_, _, agree)| *agree) {
        return (turned, one_sided);
    }
    let mut around: Vec<Vec<(usize, bool)>> = vec![Vec::new(); count];
    for &(a, b, agree) in links {
        around[a as usize].push((b as usize, agree));
        around[b as usize].push((a as usize, agree));
    }
    let mut open_edges = vec![0_usize; count];
    rims.iter().for_each(|t| open_edges[*t as usize] += 1);
    let mut reached = vec![false; count];
    for start in 0..count {
        if std::mem::replace(&mut reached[start], true) {
            continue;
        }
        let (mut patch, mut next, mut has_one_side) = (vec![start], 0, false);
        // Each edge across which two disagree is met from both.
        let mut twice_disagreeing = 0;
        while let Some(&t) = patch.get(next) {
            next += 1;
            for &(other, agree) in &around[t] {
                twice_disagreeing += usize::from(!agree);
                let turn = turned[t] == agree;
                if !std::mem::replace(&mut reached[other], true) {
                    turned[other] = turn;
                    patch.push(other);
                } else if turned[other] != turn {
                    has_one_side = true;
                }
            }
        }
        let (mut kept, mut against) = (0.0, 0.0);
        for &t in &patch {
            *(if turned[t] { &mut against } else { &mut kept }) += area(t);
        }
        let is_minority = |turned: bool| turned == (kept >= against);
        let open: usize = patch.iter().filter(|t| is_minority(turned[**t])).map(|t| open_edges[*t]).sum();
        let are_turned = !has_one_side && twice_disagreeing > 2 * open;
        for &t in &patch {
            turned[t] = are_turned && is_minority(turned[t]);
        }
        if has_one_side {
            one_sided.push(start as u32);
        }
    }
    (turned, one_sided)
}

/// A connected component.
struct Part {
    triangles: Vec<u32>,
    bounds: Bounds,
    /// Whether it faces inward; `None` if it has one side, or is too flat to have an inside.
    inward: Option<bool>,
}

/// Triangles that agree with their neighbors.
struct Surface<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
}

impl Surface<'_> {
    fn corners(&self, t: u32) -> [Vec3; 3] {
        corners(self.positions, &self.triangles[t as usize])
    }

    /// All components; those of the triangles `rims` are open, and those of `one_sided` have one side.
    fn parts(&self, rims: &[u32], one_sided: &[u32]) -> Vec<Part> {
        let component = components(self.positions.len(), self.triangles);
        let component_of = |t: u32| component[self.triangles[t as usize][0] as usize] as usize;
        let count = component.iter().max().map_or(0, |c| *c as usize + 1);
        let mut is_open = vec![false; count];
        rims.iter().for_each(|t| is_open[component_of(*t)] = true);
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); count];
        (0..self.triangles.len() as u32).for_each(|t| members[component_of(t)].push(t));
        let mut parts: Vec<Part> =
            members.into_iter().zip(is_open).map(|(members, is_open)| self.part(members, is_open)).collect();
        one_sided.iter().for_each(|t| parts[component_of(*t)].inward = None);
        // Vertices of no triangle.
        parts.retain(|part| !part.triangles.is_empty());
        parts
    }

    fn part(&self, members: Vec<u32>, is_open: bool) -> Part {
        let points: Vec<Vec3> = members.iter().flat_map(|t| self.corners(*t)).collect();
        // The volume of the cone to the origin, and the sum of the area vectors, which is zero if all is closed.
        let origin = points.first().copied().unwrap_or_default();
        let (mut volume, mut area, mut opening) = (0.0, 0.0_f64, [0.0; 3]);
        for t in &members {
            let [a, b, c] = self.corners(*t);
            let normal = scaled(doubled_area_normal([a, b, c]), 0.5);
            volume += dot(sub(a, origin), normal) / 3.0;
            area += length(normal);
            opening = add(opening, normal);
        }
        let cones = points.iter().map(|p| volume - dot(sub(*p, origin), opening) / 3.0);
        let (least, most) =
            cones.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(v), most.max(v)));
        let clear = area.powf(1.5) * if is_open { OPEN } else { CLOSED };
        let is_clear = least > clear || most < -clear;
        Part { inward: is_clear.then_some(most < 0.0), bounds: Bounds::of(points), triangles: members }
    }

    /// For each component whether it is turned: if it faces inward or, within another one, if that is turned.
    fn turns(&self, parts: &[Part]) -> Vec<bool> {
        let mut turns: Vec<bool> = parts.iter().map(|part| part.inward == Some(true)).collect();
        let normals = vertex_normals(self.positions, self.triangles);
        // Nothing lies within what has no inside.
        let solid: Vec<usize> = (0..parts.len()).filter(|i| parts[*i].inward.is_some()).collect();
        let center = |bounds: &Bounds| scaled(add(bounds.low, bounds.high), 0.5);
        let centers: Vec<Vec3> = solid.iter().map(|i| center(&parts[*i].bounds)).collect();
        let tree = BoxTree::new(&centers, |item| parts[solid[item as usize]].bounds);
        let holds = |outer: &Bounds, inner: &Bounds| outer.around(inner) == *outer;
        // What is around a component is larger, so it comes first.
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|i, j| parts[*j].bounds.diagonal().total_cmp(&parts[*i].bounds.diagonal()));
        // Of the components so far that have an inside and lie within no other one.
        let mut skins: Vec<Option<TriangleTree>> = vec![None; parts.len()];
        for i in order {
            let inner = &parts[i];
            let (mut around, mut asked) = (None, 0);
            // Larger boxes come first.
            let nearness = |bounds: &Bounds| {
                if holds(bounds, &inner.bounds) { -bounds.diagonal() } else { f64::INFINITY }
            };
            tree.search(f64::INFINITY, nearness, |slot, limit| {
                let j = solid[tree.order()[slot] as usize];
                if around.is_none()
                    && asked < AROUND
                    && holds(&parts[j].bounds, &inner.bounds)
                    && let Some(skin) = &skins[j]
                {
                    asked += 1;
                    if self.lies_within(inner, &parts[j], skin, &normals) {
                        around = Some(j);
                    }
                }
                // Nothing is nearer than this, which ends the search.
                if around.is_some() || asked == AROUND { f64::NEG_INFINITY } else { limit }
            });
            match around {
                Some(j) => turns[i] = turns[j],
                None if inner.inward.is_some() => {
                    let own: Vec<[u32; 3]> =
                        inner.triangles.iter().map(|t| self.triangles[*t as usize]).collect();
                    skins[i] = Some(TriangleTree::new(self.positions, &own));
                }
                None => {}
            }
        }
        turns
    }

    /// Whether most of a component lies behind the surface of another one, of which `skin` is the tree.
    fn lies_within(&self, inner: &Part, outer: &Part, skin: &TriangleTree, normals: &[Vec3]) -> bool {
        let step = inner.triangles.len().div_ceil(ASKED);
        let (mut within, mut asked) = (0, 0);
        for t in inner.triangles.iter().step_by(step) {
            let [point, ..] = self.corners(*t);
            let Some(at) = skin.closest(point, f64::INFINITY) else { continue };
            let there = self.triangles[outer.triangles[at.on.triangle as usize] as usize];
            let normal = mixed(there.map(|v| normals[v as usize]), at.on.weights);
            let height = dot(sub(point, at.point), normal);
            within += usize::from(if outer.inward == Some(true) { height > 0.0 } else { height < 0.0 });
            asked += 1;
        }
        2 * within > asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{grid_square, icosphere, moebius, torus};
    use crate::{HealthReport, TriMesh, weld};

    fn inward(mesh: &TriMesh) -> Vec<bool> {
        inward_triangles(&mesh.positions, &mesh.triangles)
    }

    fn turned(mut mesh: TriMesh) -> TriMesh {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh
    }

    /// `mesh` scaled and moved along x.
    fn placed(mut mesh: TriMesh, scale: f64, x: f64) -> TriMesh {
        mesh.positions.iter_mut().for_each(|p| *p = add(scaled(*p, scale), [x, 0.0, 0.0]));
        mesh
    }

    fn both(mut a: TriMesh, b: &TriMesh) -> TriMesh {
        let n = a.positions.len() as u32;
        a.positions.extend(&b.positions);
        a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + n)));
        a
    }

    #[test]
    fn a_surface_that_faces_inward_is_turned_and_one_that_faces_outward_is_not() {
        let mut cut = icosphere(3);
        cut.triangles.retain(|t| t.iter().all(|v| cut.positions[*v as usize][2] > -0.6));
        for mesh in [icosphere(2), torus(0.3, 24, 12), cut, placed(icosphere(2), 1e-3, 50.0)] {
            assert!(inward(&mesh).iter().all(|t| !t));
            assert!(inward(&turned(mesh)).iter().all(|t| *t));
        }
        assert_eq!(HealthReport::of(&turned(icosphere(2))).inward_triangles, 320);
        assert_eq!(HealthReport::of(&icosphere(2)).inward_triangles, 0);
    }

    #[test]
    fn some_triangles_that_run_against_the_others_are_turned() {
        for mesh in [icosphere(2), turned(icosphere(2)), grid_square(6)] {
            let all_turned = inward(&mesh)[0];
            let mut mixed = mesh;
            mixed.triangles.iter_mut().step_by(3).for_each(|t| t.swap(0, 1));
            for (i, t) in inward(&mixed).into_iter().enumerate() {
                assert_eq!(t, all_turned != (i % 3 == 0), "{i}");
            }
        }
    }

    #[test]
    fn pieces_that_merely_touch_keep_their_winding() {
        let flat = grid_square(3);
        let mut upright = flat.clone();
        upright.positions.iter_mut().for_each(|p| *p = [p[0], 0.0, p[1]]);
        let joined = weld(&both(flat, &upright));
        assert_eq!(joined.positions.len(), 16 + 12);
        assert!(inward_triangles(&joined.positions, &joined.triangles).iter().all(|t| !t));
    }

    #[test]
    fn what_has_no_inside_keeps_its_winding() {
        let mut twice = grid_square(6);
        twice.triangles.extend_from_within(..);
        for mesh in [grid_square(6), twice, moebius(0.4, 24, 2), TriMesh::default()] {
            assert!(inward(&mesh).iter().all(|t| !t));
            assert!(inward(&turned(mesh)).iter().all(|t| !t));
        }
    }

    #[test]
    fn what_lies_within_is_turned_with_what_is_around_it() {
        let hollow = both(icosphere(3), &turned(placed(icosphere(2), 0.5, 0.3)));
        assert!(inward(&hollow).iter().all(|t| !t));
        assert!(inward(&turned(hollow)).iter().all(|t| *t));
        // Beside it, each is judged alone; the box of the ring holds that of the ball.
        for ball in [placed(icosphere(2), 0.5, 3.0), placed(icosphere(2), 0.2, 0.0)] {
            let found = inward(&both(torus(0.3, 24, 12), &turned(ball)));
            assert_eq!(found.iter().position(|t| *t), Some(2 * 24 * 12));
            assert!(found[2 * 24 * 12..].iter().all(|t| *t));
        }
    }
}
