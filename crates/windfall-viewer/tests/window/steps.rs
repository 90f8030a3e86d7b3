//! All that is done with the window, in order.

use crate::person::{Person, SIZE};
use egui::accesskit::Role;
use egui::{Pos2, vec2};
use glam::DVec3;
use std::time::Duration;
use windfall_scenes::{CameraKey, Scene, Source};
use windfall_testing::{Snapshots, Tolerance};

/// What is done, and how.
type Step = (&'static str, fn(&mut Person));

const STEPS: [Step; 10] = [
    ("start", start),
    ("camera", camera),
    ("time", time),
    ("controls", controls),
    ("views, links, command line", out),
    ("files", files),
    ("a path is recorded", path),
    ("a leaf is clicked", leaf),
    ("resize", resize),
    ("letters of twice the size", large),
];

/// Does everything, then closes the window.
pub fn all(mut person: Person) {
    for (name, step) in STEPS {
        let start = std::time::Instant::now();
        eprintln!("step: {name}");
        step(&mut person);
        eprintln!("      {:.1} s", start.elapsed().as_secs_f64());
    }
    let of_gpu = |errors: Vec<String>| errors.into_iter().filter(|e| e.starts_with("the GPU"));
    assert_eq!(of_gpu(person.errors()).collect::<Vec<_>>(), Vec::<String>::new());
    // No frame follows.
    person.hands().key("ctrl+q");
}

/// The window and its picture are what they were when somebody looked at them.
fn window(person: &mut Person, name: &str) {
    // What is kept is drawn in full, however slow the machine is.
    person.picture();
    person.click("Clear");
    let seen = person.look();
    let size = (seen.size[0] as u32, seen.size[1] as u32);
    let of_crate = Snapshots::of_crate(env!("CARGO_MANIFEST_DIR"));
    of_crate.assert(name, size, seen.as_raw(), Tolerance::default());
}

fn start(person: &mut Person) {
    person.settle();
    person.hands();
    let first = person.picture();
    assert_eq!(person.picture(), first, "the same moment is the same picture");
    window(person, "window");
}

fn eye(scene: &Scene) -> DVec3 {
    scene.camera[0].eye.into()
}

fn target(scene: &Scene) -> DVec3 {
    scene.camera[0].target.into()
}

fn camera(person: &mut Person) {
    let middle = person.forest().center();
    let before = person.scene();
    person.drag("1", middle, middle + vec2(70.0, 20.0));
    let turned = person.scene();
    assert!(eye(&turned).distance(eye(&before)) > 1.0 && turned.camera[0].eye.1 > 0.0);
    let kept = target(&turned).distance(target(&before));
    assert!(
        kept < 0.05,
        "orbits keep their target: {kept} {:?} {:?}",
        before.camera,
        turned.camera
    );
    for _ in 0..3 {
        person.hands().press("4");
        person.hands().release("4");
    }
    std::thread::sleep(Duration::from_millis(300));
    let nearer = person.scene();
    let distance = |s: &Scene| eye(s).distance(target(s));
    assert!(distance(&nearer) < distance(&turned) - 0.1);
    person.drag("3", middle, middle + vec2(0.0, 60.0));
    assert!(target(&person.scene()).y > target(&nearer).y + 0.1, "the view goes up");
    person.key("2");
    person.hold("w", Duration::from_millis(500));
    let walked = person.scene();
    assert!((walked.camera[0].eye.1 - 1.7).abs() < 0.05, "{:?}", walked.camera[0].eye);
    person.key("3");
    person.hold("e", Duration::from_millis(500));
    let flown = person.scene();
    assert!(flown.camera[0].eye.1 > walked.camera[0].eye.1 + 0.5, "{:?}", flown.camera[0].eye);
    person.key("1");
    person.key("f");
}

fn now(person: &Person) -> f64 {
    person.frames();
    person.status(|s| s.time)
}

fn time(person: &mut Person) {
    let at_start = now(person);
    person.key("space");
    person.wait("time runs", |person| person.status(|s| s.time) > at_start + 0.3);
    person.key("space");
    person.set("time", 0.7);
    let late = now(person);
    assert!(late > 150.0, "{late}");
    let then = person.picture();
    person.set("time", 0.1);
    assert!(now(person) < 60.0);
    assert_ne!(person.picture(), then, "leaves fall");
    let back = now(person);
    person.key("period");
    assert!((now(person) - back - 1.0 / 30.0).abs() < 0.02);
    person.key("comma");
    person.key("Home");
    assert_eq!(now(person), 0.0);
}

/// Each control of a section: sliders, switches. How many of them changed what is shown.
fn section(person: &mut Person, name: &str) -> usize {
    person.section(name);
    if name == "Season and leaves" {
        person.section("How leaves fall");
    }
    let mut done = std::collections::BTreeSet::new();
    let mut changed = 0;
    let wanted = |role| matches!(role, Role::Slider | Role::CheckBox);
    loop {
        // A switch may bring others.
        let next = person.widgets().into_iter().find(|w| {
            let in_panel = w.rect.left() < 300.0 && w.rect.bottom() < SIZE.1 as f32 - 30.0;
            wanted(w.role) && w.enabled && in_panel && !w.name.is_empty() && !done.contains(&w.name)
        });
        let Some(next) = next else { break };
        let link = |person: &Person| person.status(|s| s.link.clone());
        let before = link(person);
        if next.role == Role::Slider {
            // It may be set to the one already.
            for part in [0.7, 0.3] {
                if link(person) == before {
                    person.set(&next.name, part);
                }
            }
        } else {
            person.click(&next.name);
        }
        let ignored = ["size of letters", "frame budget"].contains(&next.name.as_str());
        assert!(link(person) != before || ignored, "{name}: {} changes nothing", next.name);
        changed += 1;
        done.insert(next.name);
    }
    person.show(&name.replace(' ', "-"));
    person.section(name);
    changed
}

fn controls(person: &mut Person) {
    // Both are open at first.
    person.section("Season and leaves");
    person.section("Trees");
    let mut changed = 0;
    for name in ["Wind", "Sky", "Simplification", "Method", "Effects", "Season and leaves", "Trees"]
    {
        changed += section(person, name);
    }
    assert!(changed > 55, "{changed} controls");
    person.settle();
    assert_eq!(person.errors(), Vec::<String>::new());
    // One back and again.
    let seed = |person: &mut Person| person.scene().trees.len();
    let trees = seed(person);
    person.section("Trees");
    person.click("Add a species");
    assert_eq!(seed(person), trees + 1);
    person.key("ctrl+z");
    assert_eq!(seed(person), trees);
    person.key("ctrl+shift+z");
    assert_eq!(seed(person), trees + 1);
    person.section("Trees");
    again(person);
    person.section("Wind");
    person.set("speed, m/s", 0.9);
    let fast = person.scene().wind.speed;
    person.click("reset speed, m/s");
    assert!(person.scene().wind.speed < fast);
    person.section("Wind");
}

/// Chooses the scene anew, from the list: everything is as at the start.
fn again(person: &mut Person) {
    let list = |person: &Person| {
        person.widgets().into_iter().find(|w| w.role == Role::ComboBox && w.rect.top() < 30.0)
    };
    let at = list(person).expect("scenes").rect.center();
    person.click_at(at);
    person.frames();
    let entry = person
        .widgets()
        .into_iter()
        .find(|w| w.role == Role::Button && w.name == "lone-oak" && w.rect.top() > at.y + 10.0);
    let entry = entry.expect("lone-oak in the list").rect.center();
    person.click_at(entry);
    person.settle();
}

fn out(person: &mut Person) {
    person.section("Pictures, links, paths");
    person.click("Copy a link");
    let link = person.copied().unwrap();
    assert!(link.starts_with("#scene=lone-oak&") && link.contains("camera="), "{link}");
    person.click("Copy the command line");
    let line = person.copied().unwrap();
    assert!(line.starts_with("windfall render lone-oak") && line.contains("--camera"), "{line}");
    person.click("Bookmark this view");
    let middle = person.forest().center();
    let before = person.scene();
    person.drag("1", middle, middle + vec2(50.0, 0.0));
    person.click("1");
    assert!(eye(&person.scene()).distance(eye(&before)) < 1e-3, "the bookmark leads back");
    person.section("Pictures, links, paths");
    person.section("What goes on");
    for shown in ["leaves on the ground", "milliseconds between pictures", "λ over time"] {
        person.widget(shown);
    }
    person.show("what-goes-on");
    person.section("What goes on");
}

fn files(person: &mut Person) {
    for (name, says) in [
        ("bad.glb", "bad.glb"),
        ("bad.csv", "bad.csv"),
        ("bad.hdr", "bad.hdr"),
        ("bad.ron", "bad.ron"),
        ("nothing.glb", "nothing.glb"),
        ("notes.doc", "notes.doc: is no scene"),
    ] {
        let before = person.scene();
        let errors = person.errors().len();
        person.open(name);
        person.wait("an error", |person| person.errors().len() > errors);
        let error = person.errors().pop().unwrap();
        assert!(error.contains(says), "{name}: {error}");
        person.settle();
        assert_eq!(person.scene().trees, before.trees, "{name} changes nothing");
    }
    let errors = person.errors().len();
    person.open("birch.glb");
    let scene = person.scene();
    let own = |s: &Scene| matches!(&s.trees[0].source, Source::File(f) if f.ends_with("birch.glb"));
    assert!(scene.trees.len() == 1 && own(&scene), "{:?}", scene.trees);
    person.open("fall.csv");
    assert!(person.scene().paths[0].file.ends_with("fall.csv"));
    let before = person.picture();
    person.open("sky.hdr");
    assert_ne!(person.picture(), before);
    assert!(person.scene().sky.picture.unwrap().ends_with("sky.hdr"));
    person.show("own-files");
    // A file that changes on disk is read again.
    let notes = person.status(|s| s.notes.len());
    let bytes = std::fs::read("birch.glb").unwrap();
    std::fs::write("birch.glb", bytes).unwrap();
    person.wait("it is read again", |person| {
        person.status(|s| s.notes.iter().skip(notes).any(|n| n.contains("has changed")))
    });
    person.open("mine.ron");
    let scene = person.scene();
    assert!(scene.season == 0.25 && scene.paths.is_empty() && scene.sky.picture.is_none());
    assert_eq!(person.errors().len(), errors, "{:?}", person.errors());
    again(person);
}

fn path(person: &mut Person) {
    let middle = person.forest().center();
    person.key("Home");
    person.key("r");
    person.click("moment");
    person.write("0:02");
    person.key("Return");
    person.frames();
    person.drag("1", middle, middle + vec2(60.0, 0.0));
    person.key("r");
    let scene = person.scene();
    let keys = scene.camera;
    assert!(keys.len() == 2 && keys[1].time > keys[0].time, "{keys:?}");
    let eye = |key: &CameraKey| DVec3::from(key.eye);
    assert!(eye(&keys[0]).distance(eye(&keys[1])) > 0.5);
    person.key("Home");
    person.key("4");
    person.key("space");
    person.wait("half of the path", |person| person.status(|s| s.time) > keys[1].time * 0.5);
    person.key("space");
    // In the middle of the path the camera is at neither end of it.
    person.key("1");
    person.key("b");
    person.section("Pictures, links, paths");
    person.click("Copy the command line");
    let line = person.copied().unwrap();
    let at = line.split("--camera ").nth(1).unwrap().split(' ').next().unwrap().to_owned();
    let at: Vec<f64> = at.split(',').map(|n| n.parse().unwrap()).collect();
    let at = DVec3::new(at[0], at[1], at[2]);
    assert!(keys.iter().all(|key| eye(key).distance(at) > 0.1), "{at} {keys:?}");
    person.section("Pictures, links, paths");
    again(person);
}

fn leaf(person: &mut Person) {
    person.key("1");
    let forest = person.forest();
    let mut thrown = 0;
    // The crown is about the middle; not each pixel of it is a leaf.
    for i in 0..8 {
        let at =
            forest.center() + vec2((i % 4) as f32 * 16.0 - 24.0, (i / 4) as f32 * -20.0 - 20.0);
        person.click_at(at);
        person.frames();
        thrown = person.status(|s| s.notes.iter().filter(|n| n.ends_with("falls")).count());
        if thrown > 0 {
            break;
        }
    }
    assert!(thrown > 0, "no leaf was hit");
    assert!(!person.scene().events.is_empty());
    again(person);
}

fn resize(person: &mut Person) {
    let first = person.look();
    person.hands().resize(1, 1);
    std::thread::sleep(Duration::from_millis(500));
    person.hands().resize(SIZE.0, SIZE.1);
    person.wait("it is as large as it was", |person| {
        person.look().size == [SIZE.0 as usize, SIZE.1 as usize]
    });
    assert_eq!(first.size, [SIZE.0 as usize, SIZE.1 as usize]);
    person.settle();
}

fn large(person: &mut Person) {
    person.key("F1");
    person.widget("play, pause");
    person.key("F1");
    let context = person.status(|s| s.context.clone()).unwrap();
    context.set_theme(egui::Theme::Light);
    for _ in 0..10 {
        person.key("ctrl+plus");
    }
    person.section("Season and leaves");
    window(person, "window-in-large-letters");
    person.key("m");
    person.frames();
    assert!(person.forest().width() > 600.0);
    // The scrubber is still in the window.
    let time = person.widget("time").rect;
    assert!(time.right() <= SIZE.0 as f32 && time.width() > 120.0, "{time:?}");
    person.key("m");
    person.key("ctrl+0");
    person.hands().point(Pos2::new(5.0, 5.0));
}
