//! The surface to draw on, and how its pixels come back.

use std::ops::Deref;
use std::sync::MutexGuard;

use crate::buffers::Held;
use crate::picture::is_opaque;
use crate::{Device, Picture, Samples, ViewError, cpu, gpu};

/// A surface to draw on, and the finished picture: a texture that a window can show, or pixels in
/// memory. [`read`](Self::read) fetches either.
#[derive(Debug)]
pub struct Canvas {
    pub(crate) held: Held<cpu::Canvas, gpu::Canvas>,
}

impl Canvas {
    /// A canvas of `width` × `height` pixels, four samples each: sRGB-encoded numbers, premultiplied alpha.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn new(on: impl Into<Device>, width: u32, height: u32) -> Result<Self, ViewError> {
        Self::with_samples(on, width, height, Samples::Four)
    }

    /// As [`new`](Self::new), with the given number of samples a pixel. The processor takes four
    /// whatever is asked for: its edges cost little. [`samples`](Self::samples) says which it is.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn with_samples(
        on: impl Into<Device>,
        width: u32,
        height: u32,
        samples: Samples,
    ) -> Result<Self, ViewError> {
        let device = on.into();
        match &device {
            Device::Processor => {
                let limit = device.longest_side();
                if width == 0 || height == 0 || width > limit || height > limit {
                    return Err(ViewError::Size { width, height, limit });
                }
                Ok(Self { held: Held::Cpu(cpu::Canvas::new(width, height)) })
            }
            Device::Graphics(gpu) => {
                Ok(Self { held: Held::Gpu(gpu::Canvas::for_pictures(gpu, width, height, samples)?) })
            }
        }
    }

    /// Another canvas like this one.
    pub(crate) fn twin(&self, device: &Device) -> Result<Self, ViewError> {
        match (&self.held, device) {
            (Held::Gpu(canvas), Device::Graphics(gpu)) => Ok(Self { held: Held::Gpu(canvas.twin(gpu)?) }),
            _ => Self::new(device, self.width(), self.height()),
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        match &self.held {
            Held::Cpu(canvas) => canvas.width,
            Held::Gpu(canvas) => canvas.width,
        }
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        match &self.held {
            Held::Cpu(canvas) => canvas.height,
            Held::Gpu(canvas) => canvas.height,
        }
    }

    /// How often a pixel is sampled.
    pub fn samples(&self) -> Samples {
        match &self.held {
            Held::Cpu(_) => Samples::Four,
            Held::Gpu(canvas) => canvas.samples,
        }
    }

    /// The pixels as they lie in memory, where the processor draws: RGBA, rows from the top, premultiplied
    /// alpha. Nothing is drawn on the canvas while they are held. `None` where a graphics device draws.
    pub fn pixels(&self) -> Option<impl Deref<Target = [u8]>> {
        self.held.cpu().ok().map(|canvas| PixelsHeld(canvas.pixels()))
    }

    /// The finished picture. Alpha is straight, as PNG wants it.
    ///
    /// # Errors
    /// [`ViewError::Device`] where the device fails, [`ViewError::Shape`] where it is not the canvas's own.
    pub fn read(&self, on: impl Into<Device>) -> Result<Picture, ViewError> {
        let device = on.into();
        let mut readback = Readback::new(&device, self)?;
        readback.start(&device, self)?;
        let mut rgba = Vec::new();
        readback.finish_into(&device, &mut rgba)?;
        Ok(Picture { width: self.width(), height: self.height(), rgba })
    }
}

struct PixelsHeld<'a>(MutexGuard<'a, Vec<u8>>);

impl Deref for PixelsHeld<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

/// Reads one picture of a canvas back while later ones are drawn.
#[derive(Debug)]
pub struct Readback {
    /// Premultiplied pixels, or a read-back from a graphics device.
    held: Held<Vec<u8>, gpu::Readback>,
}

impl Readback {
    /// For pictures of the size of `canvas`.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the device is not the canvas's own.
    pub fn new(device: &Device, canvas: &Canvas) -> Result<Self, ViewError> {
        let held = match device {
            Device::Processor => Held::Cpu(Vec::new()),
            Device::Graphics(gpu) => Held::Gpu(gpu::Readback::new(gpu, canvas.held.gpu()?)),
        };
        Ok(Self { held })
    }

    /// Queues the copy of the picture drawn so far; does not wait.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the device is not the canvas's own.
    pub fn start(&mut self, device: &Device, canvas: &Canvas) -> Result<(), ViewError> {
        match (&mut self.held, device) {
            (Held::Gpu(readback), Device::Graphics(gpu)) => readback.start(gpu, canvas.held.gpu()?),
            (Held::Cpu(copy), _) => copy.clone_from(&canvas.held.cpu()?.pixels()),
            (held @ Held::Gpu(_), Device::Processor) => {
                held.cpu()?;
            }
        }
        Ok(())
    }

    /// As [`start`](Self::start), for a canvas on which a whole picture is drawn before it is read again: where the
    /// processor draws, its pixels are taken instead of copied.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub(crate) fn take(&mut self, device: &Device, canvas: &Canvas) -> Result<(), ViewError> {
        let Held::Cpu(taken) = &mut self.held else { return self.start(device, canvas) };
        let mut pixels = canvas.held.cpu()?.pixels();
        taken.resize(pixels.len(), 0);
        std::mem::swap(&mut *pixels, taken);
        Ok(())
    }

    /// Waits for the copy and unpacks it into `rgba`, with straight alpha.
    ///
    /// # Errors
    /// [`ViewError::Device`] where the device fails.
    pub fn finish_into(&mut self, device: &Device, rgba: &mut Vec<u8>) -> Result<(), ViewError> {
        match (&mut self.held, device) {
            (Held::Gpu(readback), Device::Graphics(gpu)) => readback.finish_into(gpu, rgba)?,
            (Held::Cpu(copy), _) => std::mem::swap(copy, rgba),
            (held @ Held::Gpu(_), Device::Processor) => {
                held.cpu()?;
            }
        }
        if !is_opaque(rgba) {
            rgba.as_chunks_mut::<4>().0.iter_mut().for_each(straighten);
        }
        Ok(())
    }
}

/// From premultiplied to straight alpha.
fn straighten(pixel: &mut [u8; 4]) {
    let alpha = u32::from(pixel[3]);
    if alpha == 0 || alpha == 255 {
        return;
    }
    for channel in &mut pixel[..3] {
        *channel = ((u32::from(*channel) * 255 + alpha / 2) / alpha).min(255) as u8;
    }
}
