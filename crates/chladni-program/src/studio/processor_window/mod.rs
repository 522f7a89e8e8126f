//! A window where there is no graphics card: the processor paints it, and the system shows its pixels. No driver is asked.
//!
//! egui-winit is used as in eframe; only painting and the loop around it differ. There is one main window; others are
//! its immediate viewports, which are painted while it is.

mod painter;
mod running;
mod span;
mod surface;

use std::sync::Arc;

use egui::ViewportBuilder;
use winit::event_loop::{ControlFlow, EventLoop};
use winit::window::Window;

pub use painter::Painter;
pub use running::Program;

use running::Running;

/// Why such a window cannot be.
#[derive(Debug, thiserror::Error)]
pub enum ProcessorWindowError {
    /// The system's events cannot be read.
    #[error("{0}")]
    Events(#[from] winit::error::EventLoopError),
    /// The system makes no window.
    #[error("{0}")]
    Window(#[from] winit::error::OsError),
    /// The system shows no pixels.
    #[error("{0}")]
    Pixels(String),
}

impl From<softbuffer::SoftBufferError> for ProcessorWindowError {
    // It holds handles that must stay on their thread.
    fn from(error: softbuffer::SoftBufferError) -> Self {
        Self::Pixels(error.to_string())
    }
}

/// Opens a window on what `create` makes, and returns when it is closed.
pub fn open(
    builder: ViewportBuilder,
    create: impl FnOnce(&egui::Context, &Arc<Window>) -> Box<dyn Program>,
) -> Result<(), ProcessorWindowError> {
    let events = EventLoop::with_user_event().build()?;
    events.set_control_flow(ControlFlow::Wait);
    let mut running = Running::new(builder, events.create_proxy(), create);
    events.run_app(&mut running)?;
    running.outcome()
}
