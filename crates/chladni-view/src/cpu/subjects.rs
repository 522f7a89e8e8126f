//! The data of a picture's figures, locked while they are drawn.

use std::sync::{Arc, RwLock, RwLockReadGuard};

use crate::buffers::{HostItems, Pyramid, Shared, read};
use crate::uniforms::check_figure;
use crate::{Cell, Figure, Paint, VertexPaint, ViewError};

/// Read locks on the data of all figures, held while they are drawn.
pub(super) struct Locks<'a> {
    items: Vec<Lock<'a, HostItems>>,
    paints: Vec<Lock<'a, Vec<[u8; 4]>>>,
}

/// A thing and its lock. Whatever many figures share is locked once: a thread must not wait for itself.
type Lock<'a, T> = (*const RwLock<T>, RwLockReadGuard<'a, T>);

fn lock<'a, T>(locks: &mut Vec<Lock<'a, T>>, shared: &'a Shared<T>) {
    if held(locks, shared).is_none() {
        locks.push((Arc::as_ptr(shared), read(shared)));
    }
}

fn held<'l, T>(locks: &'l [Lock<'_, T>], shared: &Shared<T>) -> Option<&'l T> {
    locks.iter().find(|(of, _)| std::ptr::eq(*of, Arc::as_ptr(shared))).map(|(_, guard)| &**guard)
}

/// The paints of a figure: its own, and its brush's reach.
fn paints<'a>(figure: &Figure<'a>) -> [Option<&'a VertexPaint>; 2] {
    let own = match figure.paint {
        Paint::Values(paint, _) | Paint::Colors(paint) => Some(paint),
        Paint::Material | Paint::Skin(_) | Paint::Answer(..) => None,
    };
    [own, figure.brush.map(|ring| &ring.reach)]
}

impl<'a> Locks<'a> {
    pub(super) fn of(cells: &[Cell<'a>]) -> Result<Self, ViewError> {
        let mut all = Self { items: Vec::new(), paints: Vec::new() };
        for figure in cells.iter().flat_map(|cell| cell.figures) {
            check_figure(figure)?;
            lock(&mut all.items, figure.buffers.held.cpu()?);
            for paint in paints(figure).into_iter().flatten() {
                lock(&mut all.paints, paint.held.cpu()?);
            }
        }
        Ok(all)
    }

    /// The figures of all cells, one after the other.
    pub(super) fn subjects<'l>(&'l self, cells: &[Cell<'l>]) -> Result<Vec<Subject<'l>>, ViewError> {
        cells.iter().flat_map(|cell| cell.figures).map(|figure| self.subject(figure)).collect()
    }

    fn subject<'l>(&'l self, figure: &Figure<'l>) -> Result<Subject<'l>, ViewError> {
        let lost = || ViewError::Shape("a figure's buffers changed while it was drawn".into());
        let items = held(&self.items, figure.buffers.held.cpu()?).ok_or_else(lost)?;
        let paint = |paint: &VertexPaint| -> Result<&'l [[u8; 4]], ViewError> {
            Ok(held(&self.paints, paint.held.cpu()?).ok_or_else(lost)?)
        };
        let n = figure.buffers.vertices;
        let vertices = figure.item * n..(figure.item + 1) * n;
        let triangles = figure.topology.held.cpu()?;
        if triangles.corners.len() >= 1 << 31 {
            return Err(ViewError::Shape(format!("{} triangles", triangles.corners.len())));
        }
        let coat = match figure.paint {
            Paint::Material => Coat::Material,
            Paint::Values(values, _) => Coat::Values(paint(values)?),
            Paint::Colors(colors) => Coat::Colors(paint(colors)?),
            Paint::Skin(skin) => Coat::Skin(skin.held.cpu()?),
            Paint::Answer(rest, _) => {
                let lag = figure.lag.map(|lag| &items.positions[lag * n..(lag + 1) * n]);
                Coat::Answer(rest.held.cpu()?, lag)
            }
        };
        let ring = match figure.brush.filter(|ring| ring.corners > 0) {
            Some(ring) => Some((&ring.triangles.cpu()?[..], paint(&ring.reach)?)),
            None => None,
        };
        Ok(Subject {
            triangles: &triangles.corners,
            uvs: &triangles.uvs,
            positions: &items.positions[vertices.clone()],
            normals: &items.normals[vertices],
            coat,
            ring,
            opacity: figure.opacity,
        })
    }
}

/// The data of one figure.
pub(super) struct Subject<'a> {
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) uvs: &'a [[f32; 2]],
    pub(super) positions: &'a [[f32; 3]],
    pub(super) normals: &'a [[f32; 3]],
    pub(super) coat: Coat<'a>,
    /// Triangles of a brush's ring, and how far each vertex is from its center.
    pub(super) ring: Option<Ring<'a>>,
    pub(super) opacity: f32,
}

type Ring<'a> = (&'a [[u32; 3]], &'a [[u8; 4]]);

/// Where a figure's color comes from.
pub(super) enum Coat<'a> {
    Material,
    Values(&'a [[u8; 4]]),
    Colors(&'a [[u8; 4]]),
    Skin(&'a Pyramid),
    /// Per vertex: the rest position with its two palette numbers, and the lag behind itself, if known.
    Answer(&'a [[f32; 5]], Option<&'a [[f32; 3]]>),
}
