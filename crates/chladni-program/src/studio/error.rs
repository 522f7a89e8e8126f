//! Why the window does not open.

use super::processor_window::ProcessorWindowError;

/// Why the window did not open.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// Neither X11 nor Wayland is there.
    #[error("the window cannot open: there is no display; 'chladni --help' lists what works without one")]
    NoDisplay,
    /// The graphics driver or the window system refused.
    #[error("the window cannot open: {0}; 'chladni --help' lists what works without one")]
    Window(#[from] eframe::Error),
    /// The window system shows no pixels.
    #[error("the window cannot open: {0}; 'chladni --help' lists what works without one")]
    Pixels(#[from] ProcessorWindowError),
    /// It was lost again as soon as a window had opened in which the processor draws.
    #[error(
        "the graphics device fails again and again ({0}); unsaved work is offered when 'chladni open' runs again"
    )]
    DeviceLost(String),
}

/// The device is missing that was asked for.
#[derive(Debug, thiserror::Error)]
#[error("no graphics device: install a Vulkan driver, or leave out '--draw gpu'")]
pub struct NoDevice;
