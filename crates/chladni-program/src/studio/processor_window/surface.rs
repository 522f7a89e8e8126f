//! One window of the system, and the pixels that it shows.

use std::num::NonZeroU32;
use std::sync::Arc;

use egui::{FullOutput, Vec2, ViewportBuilder, ViewportCommand, ViewportId, ViewportInfo};
use egui_winit::ActionRequested;
use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, OwnedDisplayHandle};
use winit::window::Window;

use super::ProcessorWindowError;
use super::painter::Painter;

/// The fill of a window before anything is painted: opaque black.
const BACKGROUND: u32 = 0xff00_0000;

/// A window that is open.
pub struct Surface {
    pub window: Arc<Window>,
    pub input: egui_winit::State,
    pub info: ViewportInfo,
    pixels: softbuffer::Surface<OwnedDisplayHandle, Arc<Window>>,
    asked: Vec<ActionRequested>,
    /// It has been painted once, and may be seen.
    is_shown: bool,
}

impl Surface {
    /// Opens a window that stays hidden until it is painted, no larger than the largest screen.
    pub fn open(
        ctx: &egui::Context,
        events: &ActiveEventLoop,
        id: ViewportId,
        builder: &ViewportBuilder,
    ) -> Result<Self, ProcessorWindowError> {
        let mut builder = builder.clone().with_visible(false);
        builder.inner_size = builder.inner_size.map(|size| within(size, ctx.zoom_factor(), screens(events)));
        let window = Arc::new(egui_winit::create_window(ctx, events, &builder)?);
        let context = softbuffer::Context::new(events.owned_display_handle())?;
        let pixels = softbuffer::Surface::new(&context, Arc::clone(&window))?;
        let (scale, theme) = (window.scale_factor() as f32, events.system_theme());
        let input = egui_winit::State::new(ctx.clone(), id, events, Some(scale), theme, None);
        let mut info = ViewportInfo::default();
        egui_winit::update_viewport_info(&mut info, ctx, &window, true);
        Ok(Self { window, input, info, pixels, asked: Vec::new(), is_shown: false })
    }

    /// Does the program's commands to the window.
    pub fn obey(&mut self, ctx: &egui::Context, commands: Vec<ViewportCommand>) {
        egui_winit::process_viewport_commands(ctx, &mut self.info, commands, &self.window, &mut self.asked);
        for asked in self.asked.drain(..) {
            let event = match asked {
                ActionRequested::Cut => egui::Event::Cut,
                ActionRequested::Copy => egui::Event::Copy,
                ActionRequested::Paste => match self.input.clipboard_text() {
                    Some(text) => egui::Event::Paste(text.replace("\r\n", "\n")),
                    None => continue,
                },
                // Nobody here asks for pictures of the window, or for frames that nobody sees.
                ActionRequested::Screenshot(_) | ActionRequested::PaintWhileHidden => continue,
            };
            self.input.egui_input_mut().events.push(event);
        }
    }

    /// Shows a frame.
    pub fn show(
        &mut self,
        ctx: &egui::Context,
        painter: &mut Painter,
        output: FullOutput,
        events: Option<&ActiveEventLoop>,
    ) -> Result<(), ProcessorWindowError> {
        let FullOutput { platform_output, mut textures_delta, shapes, pixels_per_point, .. } = output;
        match events {
            Some(events) => {
                self.input.handle_platform_output_with_event_loop(&self.window, events, platform_output);
            }
            None => self.input.handle_platform_output(&self.window, platform_output),
        }
        painter.update(&mut textures_delta);
        let painted = self.paint(painter, &ctx.tessellate(shapes, pixels_per_point), pixels_per_point);
        painter.forget(&mut textures_delta);
        if !std::mem::replace(&mut self.is_shown, true) {
            self.window.set_visible(true);
        }
        painted
    }

    fn paint(
        &mut self,
        painter: &mut Painter,
        primitives: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<(), ProcessorWindowError> {
        let size = self.window.inner_size();
        // A window that is minimized has no pixels.
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else {
            return Ok(());
        };
        self.pixels.resize(width, height)?;
        let mut pixels = self.pixels.buffer_mut()?;
        painter.paint(primitives, pixels_per_point, width.get() as usize, BACKGROUND, &mut pixels);
        self.window.pre_present_notify();
        pixels.present()?;
        Ok(())
    }
}

/// The size in pixels and the scale of each screen.
fn screens(events: &ActiveEventLoop) -> impl Iterator<Item = (PhysicalSize<u32>, f64)> {
    events.available_monitors().map(|screen| (screen.size(), screen.scale_factor()))
}

/// `size` in points, as far as the largest of `screens` has room.
fn within(size: Vec2, zoom: f32, screens: impl Iterator<Item = (PhysicalSize<u32>, f64)>) -> Vec2 {
    let points = |(pixels, scale): (PhysicalSize<u32>, f64)| {
        let points = pixels.to_logical::<f32>(f64::from(zoom) * scale);
        Vec2::new(points.width, points.height)
    };
    // A system that does not tell names none, or one without a size.
    let room = screens.map(points).reduce(Vec2::max).filter(|room| room.x > 0.0 && room.y > 0.0);
    room.map_or(size, |room| size.min(room))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_no_larger_than_the_largest_screen() {
        let within = |screens: &[(u32, u32, f64)]| {
            let screens =
                screens.iter().map(|&(width, height, scale)| (PhysicalSize::new(width, height), scale));
            within(Vec2::new(1320.0, 820.0), 1.0, screens)
        };
        assert_eq!(within(&[(1920, 1080, 1.0)]), Vec2::new(1320.0, 820.0));
        assert_eq!(within(&[(1366, 768, 1.0)]), Vec2::new(1320.0, 768.0));
        assert_eq!(within(&[(2560, 1440, 2.0), (800, 600, 1.0)]), Vec2::new(1280.0, 720.0));
        assert_eq!(within(&[]), Vec2::new(1320.0, 820.0));
        assert_eq!(within(&[(0, 0, 1.0)]), Vec2::new(1320.0, 820.0));
    }
}
