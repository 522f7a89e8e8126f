//! The window as a picture where there is no graphics card.

use chladni_program::studio::Painter;
use egui::{Context, FullOutput, TexturesDelta};
use egui_kittest::TestRenderer;
use egui_kittest::wgpu::WgpuTestRenderer;
use image::RgbaImage;

/// Paints as the window does on the processor.
#[derive(Default)]
pub struct Painted(Painter);

impl TestRenderer for Painted {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        self.0.update(delta);
        self.0.forget(delta);
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let scale = ctx.pixels_per_point();
        let size = ctx.content_rect().size() * scale;
        let [width, height] = [size.x, size.y].map(|length| length.round() as u32);
        let mut pixels = vec![0; width as usize * height as usize];
        let primitives = ctx.tessellate(output.shapes.clone(), scale);
        self.0.paint(&primitives, scale, width as usize, 0xff00_0000, &mut pixels);
        let rgba = pixels.iter().flat_map(|pixel| {
            let [a, r, g, b] = pixel.to_be_bytes();
            [r, g, b, a]
        });
        RgbaImage::from_raw(width, height, rgba.collect()).ok_or_else(|| "no picture".into())
    }
}

/// Paints in both ways, and compares.
pub struct Twins {
    ours: Painted,
    egui: WgpuTestRenderer,
}

impl Twins {
    /// `None` where there is no graphics device for egui's own painter.
    pub fn new() -> Option<Self> {
        let device = chladni_view::Gpu::headless();
        device.is_ok().then(|| Self { ours: Painted::default(), egui: WgpuTestRenderer::new() })
    }
}

impl TestRenderer for Twins {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        self.egui.handle_delta(&mut delta.clone());
        self.ours.handle_delta(delta);
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let (ours, egui) = (self.ours.render(ctx, output)?, self.egui.render(ctx, output)?);
        if ours.dimensions() != egui.dimensions() {
            return Err(format!("{:?} and {:?} pixels", ours.dimensions(), egui.dimensions()));
        }
        let differences = || {
            let pairs = ours.pixels().zip(egui.pixels());
            pairs.map(|(a, b)| (0..3).map(|i| u32::from(a[i].abs_diff(b[i]))).max().unwrap_or(0))
        };
        let count = f64::from(ours.width() * ours.height());
        let mean = differences().map(f64::from).sum::<f64>() / count;
        let far = differences().filter(|difference| *difference > 24).count() as f64 / count;
        #[allow(clippy::print_stdout, reason = "what a test measures can be read")]
        {
            println!("{mean:.3} of 255 apart in the mean, {:.3} % by more than 24", 100.0 * far);
        }
        if mean > 0.25 || far > 0.002 {
            return Err(format!("the painters differ: {mean} of 255, {far} of the pixels by more than 24"));
        }
        Ok(ours)
    }
}
