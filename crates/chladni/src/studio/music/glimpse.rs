//! A look at the picture that is about to be shown: how bright it is.

use chladni_music::Histogram;
use chladni_view::{Canvas, Gpu};
use eframe::wgpu;
use egui::Color32;

/// So many rows of the picture are fetched, spread evenly; all of a lower picture.
const ROWS: u32 = 96;
/// Every fourth pixel of a row is counted.
const STEP: usize = 4;

/// A device that takes longer has failed: the window must not wait for it.
const LONGEST: std::time::Duration = std::time::Duration::from_secs(1);

/// A buffer that rows of a canvas come back through.
#[derive(Default)]
pub struct Glimpse {
    buffer: Option<wgpu::Buffer>,
    histogram: Histogram,
}

impl Glimpse {
    /// Counts some of the pixels of what was drawn on `canvas` last. Waits until it is drawn: a
    /// guard that looks at the frame before would come too late. Translucent pixels let
    /// `behind` through.
    pub fn of(&mut self, gpu: &Gpu, canvas: &Canvas, behind: Color32) -> Result<&Histogram, String> {
        let (width, height) = (canvas.width(), canvas.height());
        let rows = height.min(ROWS);
        let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(stride) * u64::from(rows);
        let buffer = match self.buffer.take() {
            Some(buffer) if buffer.size() == size => buffer,
            _ => gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("glimpse"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
        };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for row in 0..rows {
            let y = ((2 * u64::from(row) + 1) * u64::from(height) / (2 * u64::from(rows))) as u32;
            let source = wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y, z: 0 },
                ..canvas.view().texture().as_image_copy()
            };
            let offset = u64::from(stride) * u64::from(row);
            let layout =
                wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(stride), rows_per_image: None };
            let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            let extent = wgpu::Extent3d { width, height: 1, depth_or_array_layers: 1 };
            encoder.copy_texture_to_buffer(source, target, extent);
        }
        let submission = gpu.queue.submit([encoder.finish()]);
        // Waiting for the submission calls this; a failure shows as a range that is not mapped.
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        gpu.device
            .poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(LONGEST) })
            .map_err(|error| format!("the picture could not be looked at, and is not shown: {error}"))?;
        self.histogram.clear();
        {
            let bytes = buffer.get_mapped_range(..).map_err(|error| error.to_string())?;
            for row in bytes.chunks_exact(stride as usize) {
                for &[r, g, b, a] in row[..4 * width as usize].as_chunks().0.iter().step_by(STEP) {
                    // The canvas holds colours times their opacity.
                    let over = |own: u8, behind: u8| {
                        own.saturating_add((u32::from(255 - a) * u32::from(behind) / 255) as u8)
                    };
                    self.histogram.add([over(r, behind.r()), over(g, behind.g()), over(b, behind.b())]);
                }
            }
        }
        buffer.unmap();
        self.buffer = Some(buffer);
        Ok(&self.histogram)
    }
}
