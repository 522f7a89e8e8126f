//! One window of the system, and the pixels that it shows.

use std::num::NonZeroU32;
use std::sync::Arc;

use egui::{FullOutput, ViewportBuilder, ViewportCommand, ViewportId, ViewportInfo};
use egui_winit::ActionRequested;
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
    /// Opens a window that stays hidden until it is painted.
    pub fn open(
        ctx: &egui::Context,
        events: &ActiveEventLoop,
        id: ViewportId,
        builder: &ViewportBuilder,
    ) -> Result<Self, ProcessorWindowError> {
        let window = Arc::new(egui_winit::create_window(ctx, events, &builder.clone().with_visible(false))?);
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
