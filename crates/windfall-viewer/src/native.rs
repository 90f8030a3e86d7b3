//! The window.

use crate::app::{Shared, Start, Viewer};
use anyhow::{Context, anyhow, bail};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::path::Path;
use std::sync::Arc;

/// Opens the window; returns once it is closed.
///
/// # Errors
///
/// There is no display, or no graphics adapter.
pub fn run(start: Start, size: (f32, f32)) -> anyhow::Result<()> {
    run_with(start, size, Shared::default(), |_| {})
}

/// The same for one who looks on: `shared` is told what goes on, `watch` is given egui's context before the first frame.
///
/// # Errors
///
/// There is no display, or no graphics adapter.
pub fn run_with(
    start: Start,
    size: (f32, f32),
    shared: Shared,
    watch: impl FnOnce(&egui::Context) + 'static,
) -> anyhow::Result<()> {
    let started = web_time::Instant::now();
    if !has_display() {
        bail!(
            "there is no display to open a window on; `windfall render` draws pictures without one"
        );
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Windfall")
            .with_app_id("windfall")
            .with_inner_size([size.0, size.1])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: configuration(),
        ..Default::default()
    };
    let make = move |context: &eframe::CreationContext<'_>| {
        watch(&context.egui_ctx);
        let viewer = Viewer::new(context, start, shared, started)?;
        Ok(Box::new(viewer) as Box<dyn eframe::App>)
    };
    eframe::run_native("windfall", options, Box::new(make))
        .map_err(|error| anyhow!("{error}"))
        .context("cannot open a window")
}

/// Whether a window can be opened.
pub fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// The device with what the renderer asks for.
fn configuration() -> WgpuConfiguration {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let setup = WgpuSetupCreateNew {
        instance_descriptor: wgpu::InstanceDescriptor {
            backends: wgpu::Backends::from_env().unwrap_or(backends) & backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        },
        power_preference: wgpu::PowerPreference::HighPerformance,
        device_descriptor: Arc::new(crate::device),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() }
}

/// What the command line names: the first scene or link is shown, other files are opened beside it.
///
/// # Errors
///
/// A scene or a link that cannot be read.
pub fn start(names: &[String]) -> anyhow::Result<Start> {
    let mut start = None;
    let mut open = Vec::new();
    for name in names {
        let made = if let Some((_, hash)) = name.split_once('#') {
            let (settings, camera) = crate::state::link::read(hash)?;
            // A link to a moment shows that moment.
            let playing = !hash.split('&').any(|pair| pair.starts_with("time="));
            Some(Start { camera, playing, ..Start::new(settings) })
        } else if let Some(settings) = crate::state::settings::Settings::named(name) {
            Some(Start::new(settings))
        } else if crate::files::kind(name) == Ok(crate::files::Kind::Scene) {
            Some(scene(Path::new(name))?)
        } else {
            crate::files::kind(name).map_err(|error| anyhow!("{error}"))?;
            if !Path::new(name).is_file() {
                bail!("{name}: there is no such file");
            }
            open.push(name.clone());
            None
        };
        if let Some(made) = made
            && start.replace(made).is_some()
        {
            bail!("{name}: a second scene; one is shown");
        }
    }
    let default =
        || crate::state::settings::Settings::named(windfall_scenes::NAMES[0]).map(Start::new);
    let chosen = start.is_some();
    let start = start.or_else(default).context("a default scene")?;
    Ok(Start { chosen, open, ..start })
}

fn scene(path: &Path) -> anyhow::Result<Start> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("{name}: cannot be read"))?;
    let scene = windfall_scenes::Scene::from_ron(&text, &name)?;
    let mut start = Start::new(crate::state::settings::Settings::of(&name, scene));
    path.parent().unwrap_or(Path::new("")).clone_into(&mut start.files.folder);
    Ok(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start_of(names: &[&str]) -> anyhow::Result<Start> {
        start(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn the_command_line_says_what_is_shown() {
        let default = start_of(&[]).unwrap();
        assert!(default.settings.name == "autumn" && !default.chosen && default.playing);
        let named = start_of(&["hillside"]).unwrap();
        assert!(named.settings.name == "hillside" && named.chosen && named.playing);
        let link = start_of(&["https://a.example/#scene=lone-oak&time=3&camera=0,2,9,0,5,0,50"]);
        let link = link.unwrap();
        assert!(!link.playing && link.settings.scene.time == 3.0);
        assert_eq!(link.camera.unwrap().eye, (0.0, 2.0, 9.0));
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::fs::write(file("a.ron"), default.settings.scene.to_ron()).unwrap();
        std::fs::write(file("oak.glb"), b"").unwrap();
        let both = start_of(&[&file("a.ron"), &file("oak.glb")]).unwrap();
        assert_eq!(
            (both.files.folder.as_path(), both.open),
            (folder.path(), vec![file("oak.glb")])
        );
    }

    #[test]
    fn what_cannot_be_shown_is_named() {
        let error = |names: &[&str]| format!("{:#}", start_of(names).unwrap_err());
        assert!(error(&["autumn", "hillside"]).starts_with("hillside: a second scene"));
        assert!(error(&["no-such.glb"]).starts_with("no-such.glb: there is no such file"));
        assert!(error(&["no-such.ron"]).starts_with("no-such.ron: cannot be read"));
        assert!(error(&["notes.doc"]).starts_with("notes.doc: is no scene"));
        assert!(error(&["#scene=nowhere"]).contains("nowhere"));
    }
}
