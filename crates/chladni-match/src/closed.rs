//! Makes a topological sphere from a surface: its largest component with every hole filled.

use std::collections::HashMap;

use glam::DVec3;

use crate::surface::UnitSurface;
use crate::{MatchError, Side};

/// A closed, oriented triangle mesh of genus 0 over part of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Closed {
    /// Vertices of the surface, then one vertex for each hole.
    pub points: Vec<DVec3>,
    /// Triangles of the surface, then those that fill holes.
    pub triangles: Vec<[u32; 3]>,
    /// For each of `triangles`, its neighbors across the edges opposite to its corners.
    pub across: Vec<[u32; 3]>,
    /// For each of `points` that belongs to the surface, its vertex there.
    pub surface_vertex: Vec<u32>,
    /// For each of the first `triangles`, the surface's triangle; the remaining ones fill holes.
    pub surface_triangle: Vec<u32>,
    /// The point that fills the hole with the longest rim.
    pub largest_hole: Option<u32>,
    /// For each vertex of the surface, its point here; `None` outside the largest component.
    pub point_of: Vec<Option<u32>>,
}

impl Closed {
    pub fn new(surface: &UnitSurface, side: Side) -> Result<Self, MatchError> {
        let refuse = |problem: String| MatchError::NoCommonDomain { side, problem };
        let largest = largest_component(surface);
        let mut point_of = vec![None; surface.points.len()];
        let mut surface_vertex = Vec::new();
        for v in 0..surface.points.len() {
            if surface.component[v] == largest {
                point_of[v] = Some(surface_vertex.len() as u32);
                surface_vertex.push(v as u32);
            }
        }
        let mut points: Vec<DVec3> = surface_vertex.iter().map(|v| surface.points[*v as usize]).collect();
        let (mut triangles, mut surface_triangle) = (Vec::new(), Vec::new());
        for (t, corners) in surface.triangles.iter().enumerate() {
            if let [Some(a), Some(b), Some(c)] = corners.map(|v| point_of[v as usize]) {
                triangles.push([a, b, c]);
                surface_triangle.push(t as u32);
            }
        }
        let mut largest_hole = None;
        let mut longest = 0.0;
        for hole in holes(&triangles).map_err(refuse)? {
            let center = points.len() as u32;
            let ends = hole.iter().zip(hole.iter().cycle().skip(1));
            let rim: f64 = ends.map(|(a, b)| points[*a as usize].distance(points[*b as usize])).sum();
            if rim > longest {
                (largest_hole, longest) = (Some(center), rim);
            }
            points.push(hole.iter().map(|v| points[*v as usize]).sum::<DVec3>() / hole.len() as f64);
            for i in 0..hole.len() {
                triangles.push([hole[i], hole[(i + 1) % hole.len()], center]);
            }
        }
        let across =
            neighbors(&triangles).ok_or_else(|| refuse("its orientation is not consistent".into()))?;
        let euler = points.len() as i64 - triangles.len() as i64 / 2;
        if euler != 2 {
            return Err(refuse(format!(
                "with its holes filled it has {} handles or pinched vertices, and a sphere has none",
                (2 - euler) / 2
            )));
        }
        Ok(Self { points, triangles, across, surface_vertex, surface_triangle, largest_hole, point_of })
    }
}

fn largest_component(surface: &UnitSurface) -> u32 {
    let mut area = vec![0.0; surface.components()];
    for (v, a) in surface.areas.iter().enumerate() {
        area[surface.component[v] as usize] += a;
    }
    (0..area.len()).max_by(|i, j| area[*i].total_cmp(&area[*j])).unwrap_or(0) as u32
}

/// The rims of the holes, each in the order in which a filling triangle uses its edges.
fn holes(triangles: &[[u32; 3]]) -> Result<Vec<Vec<u32>>, String> {
    let mut half: HashMap<(u32, u32), u32> = HashMap::with_capacity(3 * triangles.len());
    for t in triangles {
        for i in 0..3 {
            *half.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
    }
    let mut next: HashMap<u32, u32> = HashMap::new();
    for (&(a, b), &count) in &half {
        if count > 1 {
            return Err(
                "an edge has more than two triangles, or two that are turned against each other".into()
            );
        }
        if !half.contains_key(&(b, a)) && next.insert(b, a).is_some() {
            return Err("two holes touch at a vertex".into());
        }
    }
    let mut starts: Vec<u32> = next.keys().copied().collect();
    starts.sort_unstable();
    let mut loops = Vec::new();
    for start in starts {
        let mut hole = Vec::new();
        let mut v = start;
        while let Some(w) = next.remove(&v) {
            hole.push(v);
            v = w;
        }
        if !hole.is_empty() {
            loops.push(hole);
        }
    }
    Ok(loops)
}

fn neighbors(triangles: &[[u32; 3]]) -> Option<Vec<[u32; 3]>> {
    let mut owner: HashMap<(u32, u32), u32> = HashMap::with_capacity(3 * triangles.len());
    for (t, c) in triangles.iter().enumerate() {
        for i in 0..3 {
            if owner.insert((c[(i + 1) % 3], c[(i + 2) % 3]), t as u32).is_some() {
                return None;
            }
        }
    }
    triangles
        .iter()
        .map(|c| {
            let side = |i: usize| owner.get(&(c[(i + 2) % 3], c[(i + 1) % 3])).copied();
            Some([side(0)?, side(1)?, side(2)?])
        })
        .collect()
}
