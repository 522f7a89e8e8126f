//! Names of the controls on screen, as a screen reader says them.

use std::collections::HashSet;

use egui::accessibility::is_input;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{AccessKitNode, NodeT};

/// Fails where a control has no name, or where two of one kind in one group have the same.
pub fn check<State>(window: &Harness<'_, State>, view: &str) {
    let mut wrong = window.unnamed_widgets();
    let mut known = HashSet::new();
    for node in window.root().children_recursive() {
        let node = node.accesskit_node();
        if !is_input(node.role()) || node.is_hidden() {
            continue;
        }
        let control = format!("{:?} “{}” in “{}”", node.role(), name(&node), group(&node));
        if control.contains(|c: char| ('\u{e000}'..='\u{f8ff}').contains(&c)) {
            wrong.push(format!("an icon is said: {control}"));
        }
        if node.role() == Role::SpinButton && !name(&node).contains(char::is_alphabetic) {
            wrong.push(format!("no word is said: {control}"));
        }
        if !known.insert(control.clone()) {
            wrong.push(format!("said of two: {control}"));
        }
    }
    assert!(wrong.is_empty(), "{view}:\n{}", wrong.join("\n"));
}

fn name(node: &AccessKitNode<'_>) -> String {
    let hint = || node.data().placeholder().map(str::to_owned);
    node.label().or_else(hint).unwrap_or_default()
}

/// Name of the nearest group around a control that has one.
fn group(node: &AccessKitNode<'_>) -> String {
    let around = std::iter::successors(node.parent(), AccessKitNode::parent);
    around.filter_map(|node| node.label()).next().unwrap_or_default()
}
