//! Positions and normals where they are drawn.

use std::ops::Range;
use std::sync::{Arc, PoisonError, RwLock};

use chladni_synth::{CpuSynthesizer, Synthesizer};

use super::{Held, Shared};
use crate::gpu::{self, Use};
use crate::{Device, ViewError};

/// Positions and normals of S items of N vertices: item s at vertex offset s·N, three packed
/// f32 a vertex.
#[derive(Clone, Debug)]
pub struct ItemBuffers {
    pub(crate) vertices: usize,
    pub(crate) items: usize,
    pub(crate) held: Held<Shared<HostItems>, DeviceItems>,
}

#[derive(Debug)]
pub(crate) struct HostItems {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
}

#[derive(Clone, Debug)]
pub(crate) struct DeviceItems {
    pub(crate) positions: gpu::Buffer,
    pub(crate) normals: gpu::Buffer,
}

impl ItemBuffers {
    /// Space for `items` items of `vertices` vertices, to be filled with [`write`](Self::write).
    pub fn new(on: impl Into<Device>, vertices: usize, items: usize) -> Self {
        let held = match on.into() {
            Device::Processor => {
                let room = vec![[0.0; 3]; vertices * items];
                Held::Cpu(Arc::new(RwLock::new(HostItems { positions: room.clone(), normals: room })))
            }
            Device::Graphics(gpu) => {
                let bytes = (vertices * items * 12).max(12);
                let room = |label| gpu::room(&gpu, label, bytes, Use::Vertices);
                Held::Gpu(DeviceItems { positions: room("positions"), normals: room("normals") })
            }
        };
        Self { vertices, items, held }
    }

    /// Number of items.
    pub fn items(&self) -> usize {
        self.items
    }

    /// Number of vertices of each item.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Where the positions of an item lie in the device's buffer, and its normals in theirs.
    pub(crate) fn item_bytes(&self, item: usize) -> Range<u64> {
        let bytes = (self.vertices * 12) as u64;
        let start = item as u64 * bytes;
        start..start + bytes
    }

    /// Writes positions and normals of the items from `item` on; each slice holds a multiple of N. A
    /// graphics device queues them.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where they do not fit, an item is not whole, or another device holds the buffers.
    pub fn write(
        &self,
        on: impl Into<Device>,
        item: usize,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), ViewError> {
        let room = self.items.saturating_sub(item) * self.vertices;
        let (p, n) = (positions.len(), normals.len());
        if p != n || p > room || item > self.items {
            return Err(ViewError::Shape(format!("{p} positions and {n} normals where {room} have room")));
        }
        if !p.is_multiple_of(self.vertices) {
            let n = self.vertices;
            return Err(ViewError::Shape(format!("{p} positions, not a multiple of an item's {n} vertices")));
        }
        let first = item * self.vertices;
        match on.into() {
            Device::Processor => {
                let mut items = self.held.cpu()?.write().unwrap_or_else(PoisonError::into_inner);
                items.positions[first..first + positions.len()].copy_from_slice(positions);
                items.normals[first..first + normals.len()].copy_from_slice(normals);
            }
            Device::Graphics(gpu) => {
                let (items, offset) = (self.held.gpu()?, first as u64 * 12);
                gpu::write(&gpu, &items.positions, offset, bytemuck::cast_slice(positions));
                gpu::write(&gpu, &items.normals, offset, bytemuck::cast_slice(normals));
            }
        }
        Ok(())
    }

    /// Takes the frame that the processor has made, and as many items as it has.
    ///
    /// # Errors
    /// As [`write`](Self::write), and where the frame's items have another number of vertices.
    pub fn take_frame(&mut self, on: impl Into<Device>, frame: &CpuSynthesizer) -> Result<(), ViewError> {
        let device = on.into();
        let (found, expected) = (frame.model().vertices(), self.vertices);
        if found != expected {
            let message = format!("a frame of items of {found} vertices where {expected} are expected");
            return Err(ViewError::Shape(message));
        }
        if self.items != frame.items() {
            *self = Self::new(&device, self.vertices, frame.items());
        }
        self.write(&device, 0, frame.all_positions(), frame.all_normals())
    }
}

#[cfg(test)]
mod tests {
    use chladni_synth::{FrameSettings, Item, SynthModel};

    use super::*;

    #[test]
    fn only_whole_items_with_room_are_written() {
        let buffers = ItemBuffers::new(Device::Processor, 2, 3);
        let write = |item, count| {
            let points = vec![[1.0; 3]; count];
            buffers.write(Device::Processor, item, &points, &points)
        };
        for (item, count) in [(0, 6), (1, 4), (2, 0), (3, 0)] {
            assert!(write(item, count).is_ok(), "{count} from {item} on");
        }
        for (item, count) in [(0, 8), (0, 3), (2, 4), (3, 2), (5, 0)] {
            assert!(matches!(write(item, count), Err(ViewError::Shape(_))), "{count} from {item} on");
        }
    }

    #[test]
    fn a_frame_of_another_shape_is_refused() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let model = SynthModel::from_parts(&corners, &[[0, 1, 2]], &[1.0; 3]).unwrap();
        let mut synthesizer = CpuSynthesizer::new(model);
        synthesizer.synthesize(&[Item::default()], &FrameSettings::default()).unwrap();
        for (vertices, fits) in [(3, true), (2, false), (5, false)] {
            let mut buffers = ItemBuffers::new(Device::Processor, vertices, 1);
            assert_eq!(buffers.take_frame(Device::Processor, &synthesizer).is_ok(), fits, "{vertices}");
        }
    }
}
