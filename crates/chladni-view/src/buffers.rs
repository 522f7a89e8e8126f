//! Buffers in the memory of the device that draws: triangles, positions and normals, paint, images, brush rings.

mod brush;
mod items;
mod paint;
mod pyramid;
mod skin;
mod topology;

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

pub use self::brush::BrushRing;
#[cfg(feature = "gpu")]
pub(crate) use self::items::DeviceItems;
pub(crate) use self::items::HostItems;
pub use self::items::ItemBuffers;
pub use self::paint::VertexPaint;
pub(crate) use self::pyramid::Pyramid;
pub use self::skin::Skin;
pub use self::topology::Topology;
use crate::ViewError;

/// A thing in this machine's memory, for the processor, or on a graphics device.
#[derive(Clone, Debug)]
pub(crate) enum Held<C, G> {
    Cpu(C),
    Gpu(G),
}

impl<C, G> Held<C, G> {
    /// # Errors
    /// [`ViewError::Shape`] where a graphics device holds it.
    pub(crate) fn cpu(&self) -> Result<&C, ViewError> {
        match self {
            Self::Cpu(held) => Ok(held),
            Self::Gpu(_) => {
                Err(ViewError::Shape("the processor is to draw what a graphics device holds".into()))
            }
        }
    }

    /// # Errors
    /// [`ViewError::Shape`] where the processor holds it.
    pub(crate) fn gpu(&self) -> Result<&G, ViewError> {
        match self {
            Self::Gpu(held) => Ok(held),
            Self::Cpu(_) => {
                Err(ViewError::Shape("a graphics device is to draw what the processor holds".into()))
            }
        }
    }
}

/// Numbers in this machine's memory, shared by clones of a buffer. No code that can panic holds the lock.
pub(crate) type Shared<T> = Arc<RwLock<T>>;

pub(crate) fn read<T>(shared: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    shared.read().unwrap_or_else(PoisonError::into_inner)
}
