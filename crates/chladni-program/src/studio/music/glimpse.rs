//! Measures the brightness of the picture about to be shown, without blocking: until it is known, the
//! previous picture stays.

use std::sync::{Arc, OnceLock};

use chladni_music::Histogram;
use chladni_view::{Canvas, Gpu};
use eframe::wgpu;
use egui::Color32;

use crate::work::Error;

/// Pixels of a row that are counted at least, and rows of the picture that are fetched, spread evenly: as many as the
/// histogram has dots, all of a smaller picture.
const SEEN: [u32; 2] = Histogram::DOTS;

/// A buffer for reading back rows of a canvas, and the histogram of the last rows.
#[derive(Default)]
pub struct Glimpse {
    buffer: Option<wgpu::Buffer>,
    coming: Option<Coming>,
    histogram: Histogram,
}

/// Rows on their way.
struct Coming {
    width: u32,
    rows: u32,
    stride: u32,
    behind: Color32,
    /// Whether they are there, once that is known.
    arrived: Arc<OnceLock<bool>>,
}

impl Glimpse {
    /// Asks for some rows of what was drawn on `canvas` last. Translucent pixels will let `behind` through.
    pub fn begin(&mut self, gpu: &Gpu, canvas: &Canvas, behind: Color32) {
        // The window's canvases are textures.
        let Ok(view) = canvas.view() else { return };
        let (width, height) = (canvas.width(), canvas.height());
        let rows = height.min(SEEN[1]);
        let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(stride) * u64::from(rows);
        // A buffer that is still on its way cannot be used again.
        let idle = self.buffer.take().filter(|buffer| self.coming.is_none() && buffer.size() == size);
        let buffer = idle.unwrap_or_else(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("glimpse"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for row in 0..rows {
            let y = ((2 * u64::from(row) + 1) * u64::from(height) / (2 * u64::from(rows))) as u32;
            let source = wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y, z: 0 },
                ..view.texture().as_image_copy()
            };
            let offset = u64::from(stride) * u64::from(row);
            let layout =
                wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(stride), rows_per_image: None };
            let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            let extent = wgpu::Extent3d { width, height: 1, depth_or_array_layers: 1 };
            encoder.copy_texture_to_buffer(source, target, extent);
        }
        gpu.queue.submit([encoder.finish()]);
        let arrived = Arc::new(OnceLock::new());
        let answer = Arc::clone(&arrived);
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            let _ = answer.set(mapped.is_ok());
        });
        self.coming = Some(Coming { width, rows, stride, behind, arrived });
        self.buffer = Some(buffer);
    }

    /// Whether rows were asked for that have not come.
    pub fn is_coming(&self) -> bool {
        self.coming.is_some()
    }

    /// Checks, without waiting, whether the rows have arrived; true once they were counted.
    pub fn look(&mut self, gpu: &Gpu) -> Result<bool, Error> {
        let Some(coming) = &self.coming else { return Ok(false) };
        gpu.device.poll(wgpu::PollType::Poll).map_err(Error::other)?;
        let Some(&arrived) = coming.arrived.get() else { return Ok(false) };
        let Some((coming, buffer)) = self.coming.take().zip(self.buffer.as_ref()) else { return Ok(false) };
        if !arrived {
            self.buffer = None;
            return Err(Error::other("the picture could not be looked at, and is not shown"));
        }
        self.histogram.clear();
        {
            let bytes = buffer.get_mapped_range(..).map_err(Error::other)?;
            let (size, step) = ([coming.width, coming.rows], (coming.width / SEEN[0]).max(1) as usize);
            for (row, y) in bytes.chunks_exact(coming.stride as usize).zip(0..) {
                let pixels = row[..4 * coming.width as usize].as_chunks().0;
                for (&[r, g, b, a], x) in pixels.iter().zip(0..).step_by(step) {
                    // The canvas holds colors times their opacity.
                    let over = |own: u8, behind: u8| {
                        own.saturating_add((u32::from(255 - a) * u32::from(behind) / 255) as u8)
                    };
                    let behind = coming.behind;
                    let rgb = [over(r, behind.r()), over(g, behind.g()), over(b, behind.b())];
                    self.histogram.add([x, y], size, rgb);
                }
            }
        }
        buffer.unmap();
        Ok(true)
    }

    /// What was counted last.
    pub fn histogram(&self) -> &Histogram {
        &self.histogram
    }
}
