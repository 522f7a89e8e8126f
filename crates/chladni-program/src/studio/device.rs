//! A window on a graphics device.

use crate::work::system_fonts;

/// Why there is no content for a window.
type Refusal = Box<dyn std::error::Error + Send + Sync>;

/// Opens a window with the fonts of the system, and returns when it is closed.
pub fn open<'a>(
    name: &str,
    viewport: egui::ViewportBuilder,
    create: impl FnOnce(&eframe::CreationContext<'_>) -> Result<Box<dyn eframe::App + 'a>, Refusal> + 'a,
) -> eframe::Result {
    // Without its own feature for them, eframe would warn that fonts are missing.
    let system_font_fallback = false;
    let wgpu_options = wgpu_options();
    let options =
        eframe::NativeOptions { viewport, wgpu_options, system_font_fallback, ..Default::default() };
    let create = |creation: &eframe::CreationContext<'_>| {
        creation.egui_ctx.add_font_provider(system_fonts());
        create(creation)
    };
    eframe::run_native(name, options, Box::new(create))
}

/// eframe asks for default limits only; a basis of a large shape needs the adapter's own.
fn wgpu_options() -> eframe::egui_wgpu::WgpuConfiguration {
    use eframe::{egui_wgpu, wgpu};
    let mut options = egui_wgpu::WgpuConfiguration::default();
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = &mut options.wgpu_setup {
        setup.device_descriptor = std::sync::Arc::new(|adapter: &wgpu::Adapter| wgpu::DeviceDescriptor {
            label: Some("chladni"),
            required_limits: adapter.limits(),
            ..Default::default()
        });
    }
    options
}
