//! Requirements on a graphics device.

/// eframe asks for default limits only; a basis of a large shape needs the adapter's own.
pub fn wgpu_options() -> eframe::egui_wgpu::WgpuConfiguration {
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
