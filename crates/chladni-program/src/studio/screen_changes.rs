//! Screens that are plugged in or taken away under X11.
//!
//! winit 0.30 lists them once there, and then never learns that they change: Xlib drops the events that say so, as they are
//! of an extension that it was not introduced to (rust-windowing/winit#3405). But winit lists them anew whenever a property
//! called `RESOURCE_MANAGER` changes on one of its windows. So a second connection waits for the events, and touches that
//! property.

use std::error::Error;

use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use winit::window::Window;
use x11rb::connection::Connection;
use x11rb::protocol::randr::{ConnectionExt as _, NotifyMask};
use x11rb::protocol::xproto::{AtomEnum, ChangeWindowAttributesAux, ConnectionExt as _, EventMask, PropMode};
use x11rb::protocol::{Event, xproto};
use x11rb::rust_connection::RustConnection;

/// Has winit follow the screens as long as `window` is open. Elsewhere than under X11 it does so by itself.
pub fn follow(window: &Window) {
    let id = match window.window_handle().map(|handle| handle.as_raw()) {
        Ok(RawWindowHandle::Xlib(handle)) => u32::try_from(handle.window).ok(),
        Ok(RawWindowHandle::Xcb(handle)) => Some(handle.window.get()),
        _ => None,
    };
    let Some(id) = id else { return };
    // Without it the stage still appears on the screens that there are now.
    let _ = std::thread::Builder::new().name("screens".into()).spawn(move || watch(id));
}

/// Until the window or its server is gone.
fn watch(window: xproto::Window) -> Result<(), Box<dyn Error + Send + Sync>> {
    let (server, screen) = RustConnection::connect(None)?;
    let root = server.setup().roots.get(screen).ok_or("no such screen")?.root;
    server.randr_select_input(root, NotifyMask::SCREEN_CHANGE | NotifyMask::CRTC_CHANGE)?.check()?;
    let closing = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
    server.change_window_attributes(window, &closing)?.check()?;
    loop {
        match server.wait_for_event()? {
            Event::RandrScreenChangeNotify(_) | Event::RandrNotify(_) => touch(&server, window)?,
            Event::DestroyNotify(event) if event.window == window => return Ok(()),
            _ => {}
        }
    }
}

/// Appends nothing to the property, which the server announces as a change all the same.
fn touch(server: &RustConnection, window: xproto::Window) -> Result<(), Box<dyn Error + Send + Sync>> {
    let (name, kind) = (AtomEnum::RESOURCE_MANAGER, AtomEnum::STRING);
    server.change_property(PropMode::APPEND, window, name, kind, 8, 0, &[])?.check()?;
    Ok(())
}
