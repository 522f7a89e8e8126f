//! The device that draws the window's 3D views, and the transfer of finished pictures to the screen.

use std::sync::Arc;

use chladni_synth::DeviceLoss;
use chladni_view::{Canvas, Device, Draw, Gpu, ViewError};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use egui::{ColorImage, TextureHandle, TextureId, TextureOptions};
use winit::window::Window;

use super::error::NoDevice;

/// The device of all views, and the transfer from it to the window. Clones share both.
#[derive(Clone)]
pub struct Screen {
    device: Device,
    way: Way,
    draw: Draw,
    /// Of the device that paints the window, whatever draws the views.
    loss: DeviceLoss,
    /// Whom to ask for monitors.
    window: Option<Arc<Window>>,
}

#[derive(Clone)]
enum Way {
    /// The window's painter shows the device's textures as they are.
    Textures(RenderState),
    /// Pixels are handed to what paints the window, whatever that is.
    Pixels(egui::Context),
}

impl Screen {
    /// The window's own graphics card, or the processor where it has none: a software device would draw the same
    /// many times slower. `draw` asks for one of them.
    pub fn of(creation: &eframe::CreationContext<'_>, draw: Draw) -> Result<Self, NoDevice> {
        let state = creation.wgpu_render_state.as_ref();
        let is_card = |state: &&RenderState| state.adapter.get_info().device_type != wgpu::DeviceType::Cpu;
        let window = creation.winit_window().cloned();
        let chosen = match draw {
            Draw::Auto => state.filter(is_card),
            Draw::Gpu => Some(state.ok_or(NoDevice)?),
            Draw::Cpu => None,
        };
        let screen = match chosen {
            Some(state) => Self::within(
                window,
                Device::Graphics(Gpu::shared(state.device.clone(), state.queue.clone())),
                Way::Textures(state.clone()),
            ),
            None => Self::processor(&creation.egui_ctx, window),
        };
        let loss = state.map(|state| DeviceLoss::watch(&state.device)).unwrap_or_default();
        Ok(Self { draw, loss, ..screen })
    }

    /// The processor, for a window that is painted by anything.
    pub fn processor(ctx: &egui::Context, window: Option<Arc<Window>>) -> Self {
        let screen = Self::within(window, Device::Processor, Way::Pixels(ctx.clone()));
        Self { draw: Draw::Cpu, ..screen }
    }

    fn within(window: Option<Arc<Window>>, device: Device, way: Way) -> Self {
        #[cfg(target_os = "linux")]
        if let Some(window) = &window {
            super::screen_changes::follow(window);
        }
        Self { device, way, draw: Draw::Auto, loss: DeviceLoss::default(), window }
    }

    /// One that nobody looks at.
    pub fn unseen(device: &Device) -> Self {
        let way = Way::Pixels(egui::Context::default());
        Self { device: device.clone(), way, draw: Draw::Auto, loss: DeviceLoss::default(), window: None }
    }

    /// The device that draws.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The choice of the device for films, which open one of their own.
    pub fn draw(&self) -> Draw {
        self.draw
    }

    /// The names of the screens that there are, in the system's order; none where it does not tell.
    pub fn monitors(&self) -> Vec<String> {
        let all = self.window.iter().flat_map(|window| window.available_monitors());
        all.zip(1..).map(|(monitor, i)| monitor.name().unwrap_or_else(|| format!("Screen {i}"))).collect()
    }

    /// Word of the loss of the device that paints the window; none ever comes of the processor.
    pub fn loss(&self) -> DeviceLoss {
        self.loss.clone()
    }

    /// Has `canvas` shown under the name that `before` had, where there was one.
    pub fn hang(&self, canvas: &Canvas, before: Option<Shown>) -> Result<Shown, ViewError> {
        match (&self.way, before) {
            (Way::Textures(state), Some(Shown::Texture(hung))) => {
                let (view, id) = (canvas.view()?, hung.id);
                let linear = wgpu::FilterMode::Linear;
                state.renderer.write().update_egui_texture_from_wgpu_texture(&state.device, view, linear, id);
                Ok(Shown::Texture(hung))
            }
            (Way::Textures(state), _) => {
                let (view, linear) = (canvas.view()?, wgpu::FilterMode::Linear);
                let id = state.renderer.write().register_native_texture(&state.device, view, linear);
                Ok(Shown::Texture(Hung { id, state: state.clone() }))
            }
            (Way::Pixels(_), Some(shown @ Shown::Pixels { .. })) => Ok(shown),
            (Way::Pixels(ctx), _) => {
                let nothing = Arc::new(ColorImage::filled([1, 1], egui::Color32::TRANSPARENT));
                let handle = ctx.load_texture("view", Arc::clone(&nothing), TextureOptions::LINEAR);
                Ok(Shown::Pixels { handle, images: [Arc::clone(&nothing), nothing] })
            }
        }
    }
}

/// A picture that the window can show. Dropping it takes it down.
pub enum Shown {
    /// A texture of the device that also paints the window.
    Texture(Hung),
    /// A copy of the pixels.
    Pixels {
        handle: TextureHandle,
        /// The newest copy, which the painter may still hold, and the one before, whose memory the next one takes.
        images: [Arc<ColorImage>; 2],
    },
}

impl Shown {
    /// Its name in shapes.
    pub fn id(&self) -> TextureId {
        match self {
            Self::Texture(hung) => hung.id,
            Self::Pixels { handle, .. } => handle.id(),
        }
    }

    /// Shows the current picture of `canvas`.
    pub fn refresh(&mut self, canvas: &Canvas) {
        let Self::Pixels { handle, images } = self else { return };
        let Some(pixels) = canvas.pixels() else { return };
        images.swap(0, 1);
        let size = [canvas.width() as usize, canvas.height() as usize];
        if Arc::get_mut(&mut images[0]).is_none() {
            images[0] = Arc::default();
        }
        let Some(image) = Arc::get_mut(&mut images[0]) else { return };
        image.size = size;
        image.source_size = egui::vec2(size[0] as f32, size[1] as f32);
        image.pixels.clear();
        image.pixels.extend_from_slice(bytemuck::cast_slice(&pixels));
        drop(pixels);
        handle.set(Arc::clone(&images[0]), TextureOptions::LINEAR);
    }
}

/// A texture's place among those of the painter.
pub struct Hung {
    id: TextureId,
    state: RenderState,
}

impl Drop for Hung {
    fn drop(&mut self) {
        self.state.renderer.write().free_texture(&self.id);
    }
}
