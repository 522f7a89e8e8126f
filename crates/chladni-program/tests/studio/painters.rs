//! The window as the processor paints it, beside egui's own painter on a graphics device.

use chladni_program::studio::Studio;
use egui::Key;
use egui_kittest::Harness;

use crate::driving::painted::Twins;
use crate::driving::person::{Desk, Person};

#[test]
fn both_painters_show_the_same_window() {
    for (pixels_per_point, files) in [(1.0, &[][..]), (1.0, &["shape.obj"]), (1.5, &["shape.obj"])] {
        let Some(twins) = Twins::new() else {
            return println!("skipped: no graphics device");
        };
        let desk = Desk::new();
        let opening = desk.opening(files);
        let window = Harness::builder()
            .with_size([1100.0, 700.0])
            .with_pixels_per_point(pixels_per_point)
            .renderer(twins)
            .build_eframe(|creation| Studio::new(creation, opening).expect("a window"));
        let mut person = Person(window);
        if files.is_empty() {
            person.0.run_steps(6);
        } else {
            person.wait_to_see("Compare with a mesh");
            person.add_layer("ellipsoid");
            person.wait_until_gone("Matching");
        }
        person.0.run_steps(8);
        person.0.render().unwrap();
        person.press(Key::F1);
        person.0.run_steps(4);
        person.0.render().unwrap();
    }
}
