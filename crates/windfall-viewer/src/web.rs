//! The page: the viewer in a canvas, and what JavaScript asks of it. `web/windfall.js` is the interface for pages.

use crate::app::{Ask, Asked, Start, Status, Viewer};
use crate::files::Files;
use crate::picture::Pixels;
use crate::state::link;
use crate::state::settings::Settings;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wasm_bindgen::prelude::*;

/// The viewer in a canvas.
#[wasm_bindgen]
pub struct Handle {
    runner: eframe::WebRunner,
    asked: Asked,
    status: Arc<Mutex<Status>>,
}

/// Puts the viewer into a canvas: `hash` is a link's, `panel`, `playing` and `budget` how it starts; `trees` promises the
/// bytes of a baked tree by its name, or nothing.
///
/// # Errors
///
/// A link that cannot be read, no WebGPU.
#[wasm_bindgen]
pub async fn start(
    canvas: web_sys::HtmlCanvasElement,
    hash: String,
    panel: bool,
    playing: bool,
    budget: f32,
    trees: Option<js_sys::Function>,
) -> Result<Handle, JsValue> {
    let started = web_time::Instant::now();
    let read = link::read(&hash);
    let mistake = read.as_ref().err().map(ToString::to_string);
    let default = || Settings::named(windfall_scenes::NAMES[0]).map(|settings| (settings, None));
    let (settings, camera) = read.ok().or_else(default).ok_or("there is no scene")?;
    let files = Files { page: trees, ..Files::default() };
    let start =
        Start { camera, panel, playing, budget: Some(budget), files, ..Start::new(settings) };
    let runner = eframe::WebRunner::new();
    let (asked, status) = (Asked::default(), Arc::<Mutex<Status>>::default());
    let shared = (Rc::clone(&asked), Arc::clone(&status));
    let make = move |context: &eframe::CreationContext<'_>| {
        let mut viewer = Viewer::new(context, start, shared, started)?;
        if let Some(mistake) = mistake {
            viewer.say(true, mistake);
        }
        Ok(Box::new(viewer) as Box<dyn eframe::App>)
    };
    let options = eframe::WebOptions { wgpu_options: configuration(), ..Default::default() };
    runner.start(canvas, options, Box::new(make)).await?;
    Ok(Handle { runner, asked, status })
}

fn configuration() -> WgpuConfiguration {
    let setup = WgpuSetupCreateNew {
        instance_descriptor: wgpu::InstanceDescriptor {
            backends: wgpu::Backends::BROWSER_WEBGPU,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        },
        power_preference: wgpu::PowerPreference::HighPerformance,
        device_descriptor: Arc::new(crate::device),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() }
}

#[wasm_bindgen]
impl Handle {
    fn known(&self) -> MutexGuard<'_, Status> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ask(&self, ask: Ask) {
        self.asked.borrow_mut().push(ask);
        if let Some(context) = &self.known().context {
            context.request_repaint();
        }
    }

    /// Shows what a link's hash says.
    pub fn set(&self, hash: String) {
        self.ask(Ask::Link(hash));
    }

    /// Goes to a moment, seconds, and stands there.
    pub fn seek(&self, time: f64) {
        self.ask(Ask::Seek(time));
    }

    /// Lets time run or stand.
    pub fn play(&self, playing: bool) {
        self.ask(Ask::Play(playing));
    }

    /// Opens a file's bytes: a tree, a fall path, a scene, a picture of the sky.
    pub fn open(&self, name: String, bytes: Vec<u8>) {
        self.ask(Ask::Open(name, bytes.into()));
    }

    /// The next picture as the bytes of a PNG file.
    pub fn screenshot(&self) -> js_sys::Promise {
        js_sys::Promise::new(&mut |resolve, reject| {
            self.ask(Ask::Screenshot(Box::new(move |pixels: Pixels| {
                let (settle, value) = match crate::app::png(&pixels) {
                    Ok(bytes) => (resolve, js_sys::Uint8Array::from(&bytes[..]).into()),
                    Err(error) => (reject, JsValue::from(error)),
                };
                // A page that is gone does not listen.
                let _ = settle.call1(&JsValue::UNDEFINED, &value);
            })));
        })
    }

    /// The hash of a link to what is shown.
    pub fn link(&self) -> String {
        self.known().link.clone()
    }

    /// What goes on, as JSON: `loading`, `pictures`, `loads`, `time`, `errors`, `notes`.
    pub fn status(&self) -> String {
        self.known().json()
    }

    /// Takes the viewer out of its canvas.
    pub fn dispose(&self) {
        self.runner.destroy();
    }
}

/// Lets the browser do something else.
pub(crate) async fn next_task() {
    let promise = js_sys::Promise::new(&mut |resolve, _| {
        if let Some(window) = web_sys::window() {
            // Without a timer the promise is never kept; browsers have one.
            let _ = window.set_timeout_with_callback_and_timeout_and_arguments_0(&resolve, 1);
        }
    });
    let _ = wasm_bindgen_futures::JsFuture::from(promise).await;
}

/// The page's address without a hash.
pub(crate) fn address() -> String {
    let href = web_sys::window().and_then(|window| window.location().href().ok());
    href.and_then(|href| href.split('#').next().map(str::to_owned)).unwrap_or_default()
}

/// Lets the user save a file.
pub(crate) fn download(name: &str, kind: &str, bytes: &[u8]) -> Result<(), String> {
    let save = || -> Result<(), JsValue> {
        let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
        let options = web_sys::BlobPropertyBag::new();
        options.set_type(kind);
        let blob = web_sys::Blob::new_with_u8_array_sequence_and_options(&parts, &options)?;
        let url = web_sys::Url::create_object_url_with_blob(&blob)?;
        let document = web_sys::window().and_then(|window| window.document());
        let document = document.ok_or("there is no document")?;
        let link: web_sys::HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
        link.set_href(&url);
        link.set_download(name);
        link.click();
        web_sys::Url::revoke_object_url(&url)
    };
    save().map_err(|error| format!("{name}: cannot be saved: {error:?}"))
}
