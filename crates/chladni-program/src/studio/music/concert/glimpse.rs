//! Measures the brightness of the picture about to be shown, without blocking: until a graphics device has told it,
//! the previous picture stays. A picture drawn by the processor is read where it lies in memory.

use std::sync::{Arc, OnceLock};

use chladni_music::Histogram;
use chladni_view::{Canvas, Device, Gpu};
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

/// Rows that were asked for.
enum Coming {
    /// On their way from a graphics device.
    Rows {
        width: u32,
        rows: u32,
        stride: u32,
        behind: Color32,
        /// Whether they are there, once that is known.
        arrived: Arc<OnceLock<bool>>,
    },
    /// Counted already.
    Counted,
}

impl Glimpse {
    /// Asks for some rows of the last picture on `canvas`. Translucent pixels will let `behind` through.
    pub fn begin(&mut self, device: &Device, canvas: &Canvas, behind: Color32) {
        match device {
            Device::Graphics(gpu) => self.ask(gpu, canvas, behind),
            Device::Processor => {
                let Some(pixels) = canvas.pixels() else { return };
                let (height, stride) = (canvas.height(), 4 * canvas.width() as usize);
                let rows = height.min(SEEN[1]);
                let row = |row| pixels.get(stride * middle(row, rows, height) as usize..).unwrap_or_default();
                self.count([canvas.width(), rows], (0..rows).map(row), behind);
                self.coming = Some(Coming::Counted);
            }
        }
    }

    fn ask(&mut self, gpu: &Gpu, canvas: &Canvas, behind: Color32) {
        // The canvases of a graphics device are textures.
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
            let y = middle(row, rows, height);
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
        self.coming = Some(Coming::Rows { width, rows, stride, behind, arrived });
        self.buffer = Some(buffer);
    }

    /// Whether rows were asked for that have not come.
    pub fn is_coming(&self) -> bool {
        self.coming.is_some()
    }

    /// Checks, without waiting, whether the rows have arrived; true once they were counted.
    pub fn look(&mut self, device: &Device) -> Result<bool, Error> {
        let (width, rows, stride, behind) = match &self.coming {
            None => return Ok(false),
            Some(Coming::Counted) => {
                self.coming = None;
                return Ok(true);
            }
            Some(Coming::Rows { width, rows, stride, behind, arrived }) => {
                if let Some(gpu) = device.gpu() {
                    gpu.device.poll(wgpu::PollType::Poll).map_err(Error::other)?;
                }
                match arrived.get() {
                    None => return Ok(false),
                    Some(true) => (*width, *rows, *stride as usize, *behind),
                    Some(false) => {
                        (self.coming, self.buffer) = (None, None);
                        return Err(Error::other("the picture could not be looked at, and is not shown"));
                    }
                }
            }
        };
        self.coming = None;
        let Some(buffer) = self.buffer.clone() else { return Ok(false) };
        {
            let bytes = buffer.get_mapped_range(..).map_err(Error::other)?;
            self.count([width, rows], bytes.chunks_exact(stride), behind);
        }
        buffer.unmap();
        Ok(true)
    }

    /// Counts rows of pixels, each as long as the picture is wide or longer, over the color `behind` them.
    fn count<'a>(&mut self, size: [u32; 2], rows: impl Iterator<Item = &'a [u8]>, behind: Color32) {
        self.histogram.clear();
        let step = (size[0] / SEEN[0]).max(1) as usize;
        for (row, y) in rows.zip(0..) {
            let pixels = row.as_chunks().0.iter().take(size[0] as usize);
            for (&[r, g, b, a], x) in pixels.zip(0..).step_by(step) {
                // The canvas holds colors times their opacity.
                let over = |own: u8, behind: u8| {
                    own.saturating_add((u32::from(255 - a) * u32::from(behind) / 255) as u8)
                };
                let rgb = [over(r, behind.r()), over(g, behind.g()), over(b, behind.b())];
                self.histogram.add([x, y], size, rgb);
            }
        }
    }

    /// The last histogram.
    pub fn histogram(&self) -> &Histogram {
        &self.histogram
    }
}

/// The row of a picture of `height` rows that stands for the part with this index, of `rows`.
fn middle(row: u32, rows: u32, height: u32) -> u32 {
    ((2 * u64::from(row) + 1) * u64::from(height) / (2 * u64::from(rows))) as u32
}
