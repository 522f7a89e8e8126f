//! A window on a graphics device.

/// eframe's settings for a window, which brings the fonts of the system itself.
pub fn graphics_window(viewport: egui::ViewportBuilder) -> eframe::NativeOptions {
    // Without its own feature for them, eframe would warn that fonts are missing.
    let system_font_fallback = false;
    eframe::NativeOptions {
        viewport,
        wgpu_options: wgpu_options(),
        system_font_fallback,
        ..Default::default()
    }
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
