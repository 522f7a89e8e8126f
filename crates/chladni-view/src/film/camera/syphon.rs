//! A server of Syphon, through which programs of macOS show each other's pictures without copying them.
//!
//! Syphon.framework is not part of macOS and has no crate. It is looked for at run time, so that the program starts
//! without it, and spoken to by messages: <https://github.com/Syphon/Syphon-Framework>, `SyphonMetalServer.h`. Never run
//! where this was written; its types are checked (`cargo check --target aarch64-apple-darwin --features syphon`).
#![expect(unsafe_code, reason = "messages to a framework that Rust knows nothing of")]

use std::ffi::c_void;
use std::path::PathBuf;
use std::ptr::NonNull;

use objc2::msg_send;
use objc2::rc::{Allocated, Retained, autoreleasepool};
use objc2::runtime::{AnyClass, AnyObject, ProtocolObject};
use objc2_foundation::{NSBundle, NSDictionary, NSPoint, NSRect, NSSize, NSString};
use objc2_metal::{
    MTLCommandBuffer, MTLCommandQueue, MTLCreateSystemDefaultDevice, MTLDevice, MTLOrigin, MTLPixelFormat,
    MTLRegion, MTLSize, MTLTexture, MTLTextureDescriptor,
};

/// Whether this program can be a server of Syphon.
pub const HAS_SYPHON: bool = true;

/// A server named Chladni; it belongs to the thread that opened it.
pub(super) struct Server {
    server: Retained<AnyObject>,
    queue: Retained<ProtocolObject<dyn MTLCommandQueue>>,
    texture: Retained<ProtocolObject<dyn MTLTexture>>,
    width: usize,
    height: usize,
}

/// Where the framework may lie, the program's own first.
fn places() -> Vec<PathBuf> {
    let beside = std::env::current_exe().ok().and_then(|program| {
        let contents = program.parent()?.parent()?;
        Some(contents.join("Frameworks"))
    });
    let own = std::env::var_os("HOME").map(|home| PathBuf::from(home).join("Library/Frameworks"));
    let folders = [beside, own, Some("/Library/Frameworks".into())];
    folders.into_iter().flatten().map(|folder| folder.join("Syphon.framework")).collect()
}

/// Loads the framework; its class of servers.
fn class() -> Result<&'static AnyClass, String> {
    let loaded = places().into_iter().any(|place| {
        let Some(place) = place.to_str() else { return false };
        // SAFETY: runs the framework's initializers, as linking to it would.
        NSBundle::bundleWithPath(&NSString::from_str(place)).is_some_and(|bundle| unsafe { bundle.load() })
    });
    if !loaded {
        return Err("Syphon.framework is not installed: put it into /Library/Frameworks".into());
    }
    AnyClass::get(c"SyphonMetalServer")
        .ok_or_else(|| "this Syphon.framework has no Metal server: install version 5 or later".into())
}

impl Server {
    pub(super) fn open(width: u32, height: u32) -> Result<Self, String> {
        let class = class()?;
        let device = MTLCreateSystemDefaultDevice().ok_or("Syphon needs Metal, which this machine lacks")?;
        let queue = device.newCommandQueue().ok_or("Metal gives no queue")?;
        let (width, height) = (width as usize, height as usize);
        // SAFETY: the sides are those of a film, at least 2 and within what Metal takes.
        let descriptor = unsafe {
            MTLTextureDescriptor::texture2DDescriptorWithPixelFormat_width_height_mipmapped(
                MTLPixelFormat::RGBA8Unorm,
                width,
                height,
                false,
            )
        };
        let texture = device.newTextureWithDescriptor(&descriptor).ok_or("Metal gives no texture")?;
        let name = NSString::from_str("Chladni");
        // SAFETY: the signature is `- (id)initWithName:(NSString *) device:(id<MTLDevice>) options:(NSDictionary *)`, where
        // options may be nil.
        let server: Option<Retained<AnyObject>> = unsafe {
            let server: Allocated<AnyObject> = msg_send![class, alloc];
            let options: Option<&NSDictionary<NSString, AnyObject>> = None;
            msg_send![server, initWithName: &*name, device: &*device, options: options]
        };
        let server = server.ok_or("Syphon opens no server")?;
        Ok(Self { server, queue, texture, width, height })
    }

    /// Shows a picture of the server's size, opaque RGBA row by row from the top.
    pub(super) fn send(&mut self, rgba: &[u8]) -> Result<(), String> {
        if rgba.len() != 4 * self.width * self.height {
            return Err("a picture of another size than Syphon's".into());
        }
        autoreleasepool(|_| {
            let size = MTLSize { width: self.width, height: self.height, depth: 1 };
            let region = MTLRegion { origin: MTLOrigin { x: 0, y: 0, z: 0 }, size };
            let bytes = NonNull::from(rgba).cast::<c_void>();
            // SAFETY: the bytes are as many as the region's, and no command reads the texture: the last one was waited for.
            unsafe {
                self.texture.replaceRegion_mipmapLevel_withBytes_bytesPerRow(
                    region,
                    0,
                    bytes,
                    4 * self.width,
                );
            }
            let buffer = self.queue.commandBuffer().ok_or("Metal gives no command buffer")?;
            let whole =
                NSRect::new(NSPoint::new(0.0, 0.0), NSSize::new(self.width as f64, self.height as f64));
            // Flipped: our rows come from the top, Syphon's from the bottom.
            // SAFETY: the signature is `- (void)publishFrameTexture:(id<MTLTexture>) onCommandBuffer:(id<MTLCommandBuffer>)
            // imageRegion:(NSRect) flipped:(BOOL)`.
            let () = unsafe {
                msg_send![
                    &self.server,
                    publishFrameTexture: &*self.texture,
                    onCommandBuffer: &*buffer,
                    imageRegion: whole,
                    flipped: true
                ]
            };
            buffer.commit();
            buffer.waitUntilCompleted();
            Ok(())
        })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // SAFETY: the signature is `- (void)stop`.
        let () = unsafe { msg_send![&self.server, stop] };
    }
}
