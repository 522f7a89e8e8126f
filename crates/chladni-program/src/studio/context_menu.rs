//! Context menus that keys open, too.

use egui::{FocusDirection, Key, Modifiers, Popup, Response, SetOpenCommand, Ui};

/// Shows `contents` as the menu of a control: at the pointer once the secondary button clicks it, and beside it once it has
/// the focus and the Menu key or Shift+F10 is pressed. The focus then goes to the menu's first entry.
pub fn show(response: &Response, contents: impl FnOnce(&mut Ui)) {
    let ctx = &response.ctx;
    let asked = response.has_focus()
        && ctx.input_mut(|input| {
            input.consume_key(Modifiers::NONE, Key::Menu) || input.consume_key(Modifiers::SHIFT, Key::F10)
        });
    let mut menu = Popup::context_menu(response);
    // egui keeps the position of one that the pointer opened.
    let by_keys = asked || menu.is_open() && Popup::position_of_id(ctx, menu.get_id()).is_none();
    if asked {
        menu = menu.open_memory(SetOpenCommand::Bool(true));
    }
    if by_keys && !response.secondary_clicked() {
        menu = menu.anchor(response);
    }
    let shown = menu.show(|ui| {
        contents(ui);
        // Enter would click the control itself.
        if by_keys && response.has_focus() && !ui.is_sizing_pass() {
            ui.memory_mut(|memory| memory.move_focus(FocusDirection::Down));
        }
    });
    let is_closed = shown.is_some_and(|shown| shown.response.should_close());
    if is_closed && by_keys && !ctx.input(|input| input.pointer.any_click()) {
        response.request_focus();
    }
}

/// An entry of a menu, which closes once it is clicked: egui closes it by itself only for the pointer.
pub fn entry(ui: &mut Ui, enabled: bool, label: impl Into<String>) -> Response {
    let entry = ui.add_enabled(enabled, egui::Button::new(label.into()));
    if entry.clicked() {
        ui.close();
    }
    entry
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT, Queryable};

    use super::*;

    #[test]
    fn keys_open_the_menu_of_what_has_the_focus_and_use_it() {
        let panel = |ui: &mut Ui, deleted: &mut u32| {
            let row = ui.button("Row");
            show(&row, |ui| {
                if ui.button("Delete").clicked() {
                    *deleted += 1;
                    ui.close();
                }
            });
        };
        let mut window = Harness::builder().with_size(egui::vec2(300.0, 200.0)).build_ui_state(panel, 0);
        let press = |window: &mut Harness<'_, u32>, modifiers, key| {
            window.key_press_modifiers(modifiers, key);
            window.run_steps(3);
            window.query_by_label("Delete").is_some()
        };
        assert!(!press(&mut window, Modifiers::NONE, Key::Menu), "nothing has the focus");
        window.get_by_label("Row").focus();
        window.run_steps(3);
        for (modifiers, key) in [(Modifiers::NONE, Key::Menu), (Modifiers::SHIFT, Key::F10)] {
            assert!(press(&mut window, modifiers, key), "{key:?}");
            assert!(!press(&mut window, Modifiers::NONE, Key::Enter));
            assert!(window.get_by_label("Row").accesskit_node().is_focused());
        }
        assert_eq!(*window.state(), 2);
    }
}
