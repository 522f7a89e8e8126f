//! The device that draws, and how a picture comes to the page: a graphics card draws straight into it, once the page
//! has opened one; the pixels of the processor are fetched.

use std::cell::RefCell;

use chladni_program::work::Error;
use chladni_view::{Canvas, Device, Gpu, Picture, ViewError};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;
use wgpu::util::TextureBlitter;

/// The device of the page, and its surface.
struct Card {
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    /// Draws pictures into the page, where they cannot be copied there.
    blitter: Option<TextureBlitter>,
    /// The size of the picture.
    size: (u32, u32),
}

thread_local! {
    static CARD: RefCell<Option<Card>> = const { RefCell::new(None) };
}

/// Lets a graphics card draw from now on, straight into `picture`, through WebGL2 or WebGPU; returns its name.
/// Existing concerts and sittings stay with the device that draws them.
///
/// # Errors
/// A browser that has no such device, or a device that cannot draw into a page.
#[wasm_bindgen]
pub async fn open_card(picture: HtmlCanvasElement, by_webgl: bool) -> Result<String, JsError> {
    let backends = if by_webgl { wgpu::Backends::GL } else { wgpu::Backends::BROWSER_WEBGPU };
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    // The canvas's own context is the only adapter that WebGL has.
    let surface = instance.create_surface(wgpu::SurfaceTarget::Canvas(picture))?;
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        compatible_surface: Some(&surface),
        ..Default::default()
    };
    let adapter = instance.request_adapter(&options).await?;
    let gpu = Gpu::on_adapter(&adapter).await?;
    let description = gpu.description();
    let takes_copies = surface.get_capabilities(&adapter).usages.contains(wgpu::TextureUsages::COPY_DST);
    let blitter = (!takes_copies).then(|| TextureBlitter::new(&gpu.device, Canvas::FORMAT));
    CARD.set(Some(Card { gpu, surface, blitter, size: (0, 0) }));
    Ok(description)
}

/// Why the card of the page can draw no more, once it is lost: also while nothing is drawn.
#[wasm_bindgen]
pub fn card_lost() -> Option<String> {
    let lost = CARD.with_borrow(|card| card.as_ref().and_then(|card| card.gpu.check().err()));
    lost.map(|error| error.to_string())
}

/// No graphics card draws from now on: the page has lost it.
#[wasm_bindgen]
pub fn close_card() {
    CARD.set(None);
}

/// The device that draws everything made from now on.
pub fn device() -> Device {
    CARD.with_borrow(|card| card.as_ref().map_or(Device::Processor, |card| (&card.gpu).into()))
}

/// A picture on its way to the page.
pub struct Screen {
    device: Device,
    canvas: Canvas,
    picture: Picture,
}

impl Screen {
    pub fn new(device: Device) -> Result<Self, Error> {
        let (canvas, picture) = (Canvas::new(&device, 1, 1)?, Picture::filled(1, 1, [0; 4]));
        Ok(Self { device, canvas, picture })
    }

    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Where its renderer draws.
    pub fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// The pixels that were fetched last.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Sees to it that it has this size; whether it had.
    pub fn fit(&mut self, width: u32, height: u32) -> Result<bool, Error> {
        let had = (self.canvas.width(), self.canvas.height()) == (width, height);
        if !had {
            self.canvas = Canvas::new(&self.device, width, height)?;
        }
        Ok(had)
    }

    /// Shows the picture. Where the processor draws, the page has yet to fetch it: the pixels.
    pub fn show(&mut self) -> Result<Option<&mut Picture>, Error> {
        match &self.device {
            Device::Processor => {
                self.picture = self.canvas.read(&self.device)?;
                Ok(Some(&mut self.picture))
            }
            Device::Graphics(gpu) => {
                CARD.with_borrow_mut(|card| match card {
                    Some(card) => card.show(gpu, &self.canvas),
                    None => Err(lost("the page has closed it")),
                })?;
                Ok(None)
            }
        }
    }
}

impl Card {
    fn show(&mut self, gpu: &Gpu, canvas: &Canvas) -> Result<(), Error> {
        let size = (canvas.width(), canvas.height());
        if self.size != size {
            self.surface.configure(
                &gpu.device,
                &wgpu::SurfaceConfiguration {
                    usage: match self.blitter {
                        Some(_) => wgpu::TextureUsages::RENDER_ATTACHMENT,
                        None => wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_DST,
                    },
                    format: Canvas::FORMAT,
                    color_space: wgpu::SurfaceColorSpace::Auto,
                    width: size.0,
                    height: size.1,
                    present_mode: wgpu::PresentMode::Fifo,
                    desired_maximum_frame_latency: 2,
                    alpha_mode: wgpu::CompositeAlphaMode::Opaque,
                    view_formats: Vec::new(),
                },
            );
            self.size = size;
        }
        let page = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(page) | wgpu::CurrentSurfaceTexture::Suboptimal(page) => {
                page
            }
            other => return Err(lost(&format!("{other:?}"))),
        };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let drawn = canvas.view()?;
        if let Some(blitter) = &self.blitter {
            let view = page.texture.create_view(&wgpu::TextureViewDescriptor::default());
            blitter.copy(&gpu.device, &mut encoder, drawn, &view);
        } else {
            let whole = wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 };
            let drawn = drawn.texture().as_image_copy();
            encoder.copy_texture_to_texture(drawn, page.texture.as_image_copy(), whole);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.queue.present(page);
        Ok(())
    }
}

fn lost(why: &str) -> Error {
    ViewError::Device(why.to_owned()).into()
}
