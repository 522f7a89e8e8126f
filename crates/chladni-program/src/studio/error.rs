//! Why the window does not open.

/// Why the window did not open.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// Neither X11 nor Wayland is there.
    #[error("the window cannot open: there is no display; 'chladni --help' lists what works without one")]
    NoDisplay,
    /// No usable graphics driver, or the window system refused.
    #[error("the window cannot open: {0}; 'chladni --help' lists what works without one")]
    Window(#[from] eframe::Error),
    /// It was lost again as soon as another window had opened.
    #[error(
        "the graphics device fails again and again ({0}); unsaved work is offered when 'chladni open' runs again"
    )]
    DeviceLost(String),
}

/// The device is missing where the window was made without wgpu.
#[derive(Debug, thiserror::Error)]
#[error("no graphics device: install a Vulkan driver (lavapipe, package mesa-vulkan-drivers, needs no card)")]
pub struct NoDevice;
