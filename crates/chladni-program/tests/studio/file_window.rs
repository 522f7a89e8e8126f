//! The file window that comes where the system has none.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use chladni_program::studio::{FileWindow, Purpose, Request, Settings};
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::driving::painted::Painted;
use crate::driving::person::Desk;
use crate::driving::{control, screenshot};
use crate::{CTRL, settle_on_screen};

type Answer = Rc<RefCell<Vec<PathBuf>>>;

/// The file window on a folder with two meshes and another in a folder of its own, and its answer.
fn file_window(desk: &Desk, purpose: Purpose) -> (Harness<'static, FileWindow>, Answer) {
    file_window_with(desk, purpose, Settings::default())
}

/// The same with other preferences.
fn file_window_with(
    desk: &Desk,
    purpose: Purpose,
    settings: Settings,
) -> (Harness<'static, FileWindow>, Answer) {
    file_window_at(desk, purpose, settings, desk.folder.path().to_owned())
}

/// The same that begins elsewhere.
fn file_window_at(
    desk: &Desk,
    purpose: Purpose,
    settings: Settings,
    start: PathBuf,
) -> (Harness<'static, FileWindow>, Answer) {
    std::fs::create_dir(desk.path("sculptures")).unwrap();
    std::fs::copy(desk.path("shape.obj"), desk.path("sculptures/bust.obj")).unwrap();
    let answer = Rc::new(RefCell::new(Vec::new()));
    let given = answer.clone();
    let kinds = vec![("Meshes".to_owned(), vec!["obj".to_owned()])];
    let request = Request { purpose, kinds, start };
    let mut window = Harness::builder()
        .with_size([640.0, 520.0])
        .renderer(Painted::default())
        .build_eframe(move |creation| FileWindow::new(&creation.egui_ctx, request, &settings, given));
    window.run_steps(3);
    (window, answer)
}

/// Clicks the line called `name`, after its icon.
fn click_line(window: &mut Harness<'_, FileWindow>, name: &str, modifiers: Modifiers) {
    window.query_all_by_label_contains(name).next().unwrap().click_modifiers(modifiers);
    window.run_steps(6);
}

/// Clicks that line twice in one moment, some time after all clicks before.
fn double_click_line(window: &mut Harness<'_, FileWindow>, name: &str) {
    let later = window.ctx.input(|input| input.time) + 10.0;
    window.input_mut().time = Some(later);
    for _ in 0..2 {
        window.query_all_by_label_contains(name).next().unwrap().click();
    }
    window.run_steps(6);
    window.input_mut().time = None;
}

fn type_text(window: &mut Harness<'_, FileWindow>, text: &str) {
    window.key_press_modifiers(CTRL, Key::A);
    window.event(egui::Event::Text(text.into()));
    window.run_steps(2);
}

/// The file window that comes where the system has none: a path is typed, completed, and chosen.
#[test]
fn a_path_is_typed_where_the_system_has_no_file_dialog() {
    let desk = Desk::new();
    let (mut window, answer) = file_window(&desk, Purpose::Open);
    assert!(window.query_all_by_label_contains("shape.obj").next().is_some());
    assert!(window.query_all_by_label_contains("settings.toml").next().is_none());
    type_text(&mut window, "nothing");
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(window.query_all_by_label_contains("is not there").next().is_some());
    type_text(&mut window, "scu");
    window.key_press(Key::Tab);
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
    screenshot(&mut window, "studio-files.png");
    // Once there is nothing to complete, Tab leaves the field.
    type_text(&mut window, "bust.obj");
    window.key_press(Key::Tab);
    window.run_steps(3);
    assert!(!control(&window, "path").is_focused());
    click_line(&mut window, "bust.obj", Modifiers::NONE);
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("sculptures/bust.obj")]);
}

#[test]
fn what_is_typed_after_files_were_picked_counts_and_enter_on_cancel_is_no_answer() {
    let desk = Desk::new();
    let (mut window, answer) = file_window(&desk, Purpose::OpenSeveral);
    click_line(&mut window, "shape.obj", Modifiers::NONE);
    click_line(&mut window, "template.obj", CTRL);
    assert_eq!(control(&window, "path").value().as_deref(), Some("2 files"));
    control(&window, "cancel").focus();
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert!(answer.borrow().is_empty());

    control(&window, "path").click();
    window.run_steps(2);
    type_text(&mut window, "sculptures/bust.obj");
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("sculptures/bust.obj")]);
}

#[test]
fn what_is_typed_at_first_takes_the_place_of_a_proposed_name_before_its_extension() {
    let desk = Desk::new();
    let start = desk.path("new shape.obj");
    let (mut window, answer) = file_window_at(&desk, Purpose::Save, Settings::default(), start);
    let typed = |window: &mut Harness<'_, FileWindow>, text: &str| {
        window.event(egui::Event::Text(text.into()));
        window.run_steps(2);
        control(window, "path").value()
    };
    assert_eq!(typed(&mut window, "shape").as_deref(), Some("shape.obj"));
    // It is there already: what is typed after the question goes on from there.
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(answer.borrow().is_empty());
    assert_eq!(typed(&mut window, "-2").as_deref(), Some("shape-2.obj"));
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("shape-2.obj")]);
}

#[test]
fn letters_of_the_file_window_fit_the_screen() {
    let desk = Desk::new();
    let settings = Settings { zoom: 3.0, ..Settings::default() };
    let (mut window, _) = file_window_with(&desk, Purpose::Open, settings);
    let screen = vec2(700.0, 520.0);
    settle_on_screen(&mut window, screen);
    // 360 points of the smallest window and 80 of frames and bars fill the height.
    let zoom = window.ctx.zoom_factor();
    assert!((zoom - 440.0 / 360.0).abs() < 1e-3, "{zoom}");
}

#[test]
fn a_double_click_opens_a_file_and_on_a_folder_only_that() {
    let desk = Desk::new();
    let (mut window, answer) = file_window(&desk, Purpose::Open);
    let line = |window: &Harness<'_, FileWindow>, name: &str| {
        window.query_all_by_label_contains(name).next().unwrap().rect()
    };
    let folder = line(&window, "sculptures");
    double_click_line(&mut window, "sculptures");
    assert!(answer.borrow().is_empty(), "nobody chose the file that came under the pointer");
    assert!(line(&window, "bust.obj").contains(folder.center()));
    double_click_line(&mut window, "bust.obj");
    assert_eq!(*answer.borrow(), [desk.path("sculptures/bust.obj")]);
}

#[test]
fn of_a_long_folder_only_what_is_seen_is_laid_out_and_its_end_can_be_reached() {
    let desk = Desk::new();
    for index in 0..400 {
        std::fs::write(desk.path(&format!("many-{index:03}.obj")), "").unwrap();
    }
    let (mut window, answer) = file_window(&desk, Purpose::Open);
    let lines = |window: &Harness<'_, FileWindow>| window.query_all_by_label_contains("many-").count();
    assert!((5..40).contains(&lines(&window)), "{}", lines(&window));
    window.hover_at(egui::pos2(400.0, 300.0));
    window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Page,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, -1000.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    window.run_steps(60);
    assert!((5..40).contains(&lines(&window)), "{}", lines(&window));
    let last = window.get_all_by_label_contains("template.obj").last().unwrap().rect();
    assert!(last.bottom() < 480.0, "the last line ends at {}", last.bottom());
    click_line(&mut window, "template.obj", Modifiers::NONE);
    window.key_press(Key::Enter);
    window.run_steps(2);
    assert_eq!(*answer.borrow(), [desk.path("template.obj")]);
}

#[test]
fn tab_comes_to_every_line_of_a_long_folder() {
    let desk = Desk::new();
    for index in 0..30 {
        std::fs::write(desk.path(&format!("many-{index:02}.obj")), "").unwrap();
    }
    let (mut window, _) = file_window(&desk, Purpose::Open);
    let mut reached = std::collections::BTreeSet::new();
    for _ in 0..60 {
        window.key_press(Key::Tab);
        window.run_steps(4);
        let lines = window.query_all_by_label_contains("many-").map(|line| line.accesskit_node());
        reached.extend(lines.filter(|line| line.is_focused()).filter_map(|line| line.label()));
    }
    assert_eq!(reached.len(), 30, "{reached:?}");
}
