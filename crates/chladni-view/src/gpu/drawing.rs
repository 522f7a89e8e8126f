//! The parts of drawing that are made once on a device and shared by all its renderers.

use std::sync::OnceLock;

use super::images::Common;
use super::pipelines::{Layouts, Pipelines};
use super::{finishing, focus};
use crate::{Gpu, Samples};

/// Layouts, pipelines, samplers and color maps of a device.
#[derive(Debug)]
pub(super) struct Drawing {
    pub(super) layouts: Layouts,
    pub(super) pipelines: Pipelines,
    pub(super) common: Common,
    finishing: OnceLock<finishing::Pipelines>,
    /// For one sample a pixel, and for four.
    focusing: [OnceLock<focus::Pipelines>; 2],
}

impl Drawing {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let layouts = Layouts::new(&gpu.device, gpu.lookup());
        Self {
            pipelines: Pipelines::new(&gpu.device, &layouts, gpu.lookup()),
            common: Common::new(gpu),
            layouts,
            finishing: OnceLock::new(),
            focusing: Default::default(),
        }
    }

    /// The pipelines of the finish; the first call compiles them.
    pub(super) fn finishing(&self, device: &wgpu::Device) -> &finishing::Pipelines {
        self.finishing.get_or_init(|| finishing::Pipelines::new(device))
    }

    /// The pipelines of depth of field; the first call for `samples` compiles them.
    pub(super) fn focusing(&self, device: &wgpu::Device, samples: Samples) -> &focus::Pipelines {
        let slot = &self.focusing[usize::from(samples == Samples::Four)];
        slot.get_or_init(|| focus::Pipelines::new(device, samples))
    }
}
