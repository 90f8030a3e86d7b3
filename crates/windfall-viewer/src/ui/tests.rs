//! The panel, driven without a window.

use super::panel;
use crate::app::{Start, Viewer};
use crate::input::Action;
use crate::state::settings::Settings;
use egui::accesskit::Role;
use egui::{Key, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

const SECTIONS: [&str; 9] = [
    "Wind",
    "Sky",
    "Simplification",
    "Method",
    "Effects",
    "View",
    "Pictures, links, paths",
    "What goes on",
    "How leaves fall",
];

fn viewer() -> Viewer {
    let start = Start::new(Settings::named("lone-oak").unwrap());
    Viewer::waiting(start, Default::default(), web_time::Instant::now())
}

/// The panel with all sections open, and what a frame does with changes.
fn harness(size: Vec2) -> Harness<'static, Viewer> {
    let frame = |ui: &mut egui::Ui, viewer: &mut Viewer| {
        let before = viewer.settings.clone();
        panel(viewer, ui);
        super::help::help(viewer, ui.ctx());
        let holding = ui.input(|input| input.pointer.any_down());
        viewer.changed(&before, holding);
    };
    let mut harness = Harness::builder().with_size(size).build_ui_state(frame, viewer());
    for section in SECTIONS {
        harness.get_by_label(section).click();
        harness.run_steps(8);
    }
    harness
}

#[test]
fn a_value_is_set_reset_and_taken_back() {
    let mut harness = harness(Vec2::new(420.0, 4000.0));
    let season = |harness: &Harness<'_, Viewer>| harness.state().settings.scene.season;
    let first = season(&harness);
    assert!(harness.query_by_label("reset season").is_none());
    let of_season =
        |n: &egui_kittest::Node<'_>| n.accesskit_node().label().as_deref() == Some("season");
    harness.get_all_by_role(Role::Slider).find(of_season).unwrap().focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    let set = season(&harness);
    assert_ne!(set, first);
    harness.get_by_label("reset season").click();
    harness.run_steps(4);
    assert_eq!(season(&harness), first);
    harness.state_mut().act(Action::Undo);
    harness.run_steps(2);
    assert_eq!(season(&harness), set);
    harness.get_by_label("Undo").click();
    harness.run_steps(4);
    assert_eq!(season(&harness), first);
    harness.get_by_label("Redo").click();
    harness.run_steps(4);
    assert_eq!(season(&harness), set);
}

/// Whatever is set, the scene is one that can be saved, and a link that leads back to it.
#[test]
fn every_control_leaves_a_scene_that_can_be() {
    let mut harness = harness(Vec2::new(420.0, 4000.0));
    let mut changed = 0;
    for role in [Role::Slider, Role::SpinButton, Role::CheckBox] {
        let count = harness.query_all_by_role(role).count();
        assert!(count > 5, "{role:?}: {count}");
        for i in 0..count {
            let before = harness.state().settings.clone();
            // A switch may have taken some away.
            let Some(node) = harness.query_all_by_role(role).nth(i) else { continue };
            if node.accesskit_node().is_disabled() {
                continue;
            }
            if role == Role::CheckBox {
                node.click_accesskit();
            } else {
                node.focus();
                harness.run_steps(2);
                harness.key_press(Key::ArrowUp);
                harness.run_steps(1);
                harness.key_press(Key::ArrowRight);
            }
            harness.run_steps(3);
            let viewer = harness.state();
            viewer.settings.scene.check("settings").unwrap();
            changed += u32::from(viewer.settings != before);
            let (back, _) = crate::state::link::read(&viewer.link()).unwrap();
            assert_eq!(back.scene.detail, viewer.settings.scene.detail);
            assert_eq!(back.scene.fall, viewer.settings.scene.fall);
        }
    }
    assert!(changed > 60, "{changed}");
    assert!(harness.state().lines.iter().all(|line| !line.error));
}

#[test]
fn it_holds_at_twice_the_size_and_in_both_themes() {
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        let mut harness = harness(Vec2::new(330.0, 700.0));
        harness.ctx.set_theme(theme);
        harness.set_pixels_per_point(2.0);
        harness.run_steps(3);
        harness.get_by_label("Keys").click_accesskit();
        harness.run_steps(3);
        assert!(harness.query_by_label("play, pause").is_some());
    }
}

/// In half of a narrow window no word of the panel is cut off.
#[test]
fn every_row_fits_a_narrow_panel() {
    let width = 190.0;
    let harness = harness(Vec2::new(width, 6000.0));
    let mut labels = 0;
    for role in [Role::Label, Role::CheckBox, Role::Slider, Role::SpinButton, Role::Button] {
        for node in harness.query_all_by_role(role) {
            let name = node.accesskit_node().label().or_else(|| node.accesskit_node().value());
            let right = node.rect().right();
            assert!(right <= width, "{role:?} {name:?} ends at {right}");
            labels += 1;
        }
    }
    assert!(labels > 100, "{labels}");
}
