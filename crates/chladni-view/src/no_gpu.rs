//! Stands in for graphics devices in builds without them: a device can be requested, but there never is one.

use crate::{Cell, Finish, Samples, Surroundings, ViewError};

/// A graphics device; this build has none, so no value of this type exists.
#[derive(Clone, Debug)]
pub enum Gpu {}

impl Gpu {
    /// Opens no device.
    ///
    /// # Errors
    /// [`ViewError::NoAdapter`], always.
    pub fn headless() -> Result<Self, ViewError> {
        Err(ViewError::NoAdapter("this program was built without graphics devices".into()))
    }

    pub(crate) fn has_card() -> bool {
        false
    }

    pub(crate) fn card() -> Result<Option<Self>, ViewError> {
        Ok(None)
    }

    /// Name and kind of the adapter.
    pub fn description(&self) -> String {
        match *self {}
    }

    /// Whether drawing runs on the processor.
    pub fn is_software(&self) -> bool {
        match *self {}
    }

    /// Samples a pixel for moving pictures.
    pub fn live_samples(&self) -> Samples {
        match *self {}
    }

    pub(crate) fn longest_side(&self) -> u32 {
        match *self {}
    }
}

#[derive(Clone, Debug)]
pub(crate) enum Buffer {}

#[derive(Clone, Debug)]
pub(crate) enum Image {}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Use {
    Vertices,
    Indices,
}

pub(crate) fn filled(gpu: &Gpu, _label: &str, _contents: &[u8], _used: Use) -> Buffer {
    match *gpu {}
}

pub(crate) fn looked_up(gpu: &Gpu, _triangles: &Buffer, _contents: &[u8]) -> Buffer {
    match *gpu {}
}

pub(crate) fn room(gpu: &Gpu, _label: &str, _bytes: usize, _used: Use) -> Buffer {
    match *gpu {}
}

pub(crate) fn write(gpu: &Gpu, _buffer: &Buffer, _offset: u64, _bytes: &[u8]) {
    match *gpu {}
}

pub(crate) fn size(buffer: &Buffer) -> u64 {
    match *buffer {}
}

pub(crate) fn image(gpu: &Gpu, _label: &str, _size: [u32; 3], _pyramid: &[u8]) -> Image {
    match *gpu {}
}

#[derive(Debug)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) samples: Samples,
    nobody: Gpu,
}

impl Canvas {
    pub(crate) fn for_pictures(
        gpu: &Gpu,
        _width: u32,
        _height: u32,
        _samples: Samples,
    ) -> Result<Self, ViewError> {
        match *gpu {}
    }

    pub(crate) fn twin(&self, _gpu: &Gpu) -> Result<Self, ViewError> {
        match self.nobody {}
    }
}

#[derive(Debug)]
pub(crate) enum Readback {}

impl Readback {
    pub(crate) fn new(gpu: &Gpu, _canvas: &Canvas) -> Self {
        match *gpu {}
    }

    pub(crate) fn start(&mut self, gpu: &Gpu, _canvas: &Canvas) {
        match *gpu {}
    }

    pub(crate) fn finish_into(&mut self, gpu: &Gpu, _rgba: &mut Vec<u8>) -> Result<(), ViewError> {
        match *gpu {}
    }
}

#[derive(Debug)]
pub(crate) enum Renderer {}

impl Renderer {
    pub(crate) fn for_pictures(gpu: &Gpu) -> Self {
        match *gpu {}
    }

    pub(crate) fn surround(&mut self, _surroundings: &Surroundings) -> Result<(), ViewError> {
        match *self {}
    }

    pub(crate) fn draw(
        &mut self,
        _canvas: &Canvas,
        _cells: &[Cell<'_>],
        _finish: (&Finish, f64),
    ) -> Result<(), ViewError> {
        match *self {}
    }
}
