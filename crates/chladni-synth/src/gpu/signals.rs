//! Masks and residuals on the device, each uploaded once and kept while frames use it.

use std::sync::Arc;

use super::buffer::GrowingBuffer;
use crate::{Residual, SynthError};

/// A mask or a residual.
#[derive(Clone, Debug)]
pub(super) enum Signal {
    Scalar(Arc<[f32]>),
    Vector(Arc<[[f32; 3]]>),
}

impl From<&Residual> for Signal {
    fn from(residual: &Residual) -> Self {
        match residual {
            Residual::Vector(r) => Self::Vector(Arc::clone(r)),
            Residual::Normal(r) => Self::Scalar(Arc::clone(r)),
        }
    }
}

impl Signal {
    /// Whether both are the same allocation, and therefore have the same values.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Scalar(a), Self::Scalar(b)) => Arc::ptr_eq(a, b),
            (Self::Vector(a), Self::Vector(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    fn scalars(&self) -> &[f32] {
        match self {
            Self::Scalar(s) => s,
            Self::Vector(v) => v.as_flattened(),
        }
    }
}

#[derive(Debug)]
struct Slot {
    /// Keeps the allocation alive: its address cannot be reused.
    signal: Signal,
    first: usize,
    in_use: bool,
}

/// All signals in one buffer of scalars.
#[derive(Debug)]
pub(super) struct SignalPool {
    buffer: GrowingBuffer,
    slots: Vec<Slot>,
    end: usize,
}

impl SignalPool {
    pub fn new(device: &wgpu::Device) -> Self {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = GrowingBuffer::new(device, "masks and residuals", usage);
        Self { buffer, slots: Vec::new(), end: 0 }
    }

    pub fn buffer(&self) -> &wgpu::Buffer {
        self.buffer.buffer()
    }

    /// Forgets all signals.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.end = 0;
    }

    /// Starts a frame that uses `signals`. The slots of all other signals become free.
    pub fn begin(&mut self, signals: impl Iterator<Item = Signal>) {
        self.slots.iter_mut().for_each(|slot| slot.in_use = false);
        for signal in signals {
            if let Some(slot) = self.slots.iter_mut().find(|slot| slot.signal.is(&signal)) {
                slot.in_use = true;
            }
        }
    }

    /// The index of the first scalar of `signal`, which is uploaded if it is new; and whether the buffer
    /// was replaced.
    pub fn place(&mut self, queue: &wgpu::Queue, signal: Signal) -> Result<(u32, bool), SynthError> {
        if let Some(slot) = self.slots.iter().find(|slot| slot.signal.is(&signal)) {
            return Ok((slot.first as u32, false));
        }
        let len = signal.scalars().len();
        let free = self.slots.iter_mut().find(|slot| !slot.in_use && slot.signal.scalars().len() == len);
        let first = match free {
            Some(slot) => {
                (slot.signal, slot.in_use) = (signal, true);
                slot.first
            }
            None => {
                let first = self.end;
                self.end += len;
                self.slots.push(Slot { signal, first, in_use: true });
                first
            }
        };
        let bytes = 4 * self.end as u64;
        let grown = bytes > self.buffer().size();
        if grown {
            // Twice the size needed, to grow rarely, but no more than the device has. Without room nothing of
            // this frame is kept, or the next one would find signals that were never uploaded.
            let reserved = self.buffer.reserve(2 * bytes).or_else(|_| self.buffer.reserve(bytes));
            reserved.inspect_err(|_| self.clear())?;
        }
        for slot in self.slots.iter().filter(|slot| grown || slot.first == first) {
            let scalars = bytemuck::cast_slice(slot.signal.scalars());
            queue.write_buffer(self.buffer.buffer(), 4 * slot.first as u64, scalars);
        }
        Ok((first as u32, grown))
    }
}
