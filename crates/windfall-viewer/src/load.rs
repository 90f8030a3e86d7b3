//! From settings to a forest on the GPU, step by step, beside the frames: on a thread in a program, between
//! frames in a browser.

use crate::files::Files;
use crate::state::settings::Settings;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use windfall_core::Note;
use windfall_core::tree::Tree;
use windfall_gpu::{Options, Renderer, SkyMap, TreeModel};
use windfall_scenes::{Model, PathEntry, PlantedStage, Scene, Stage, TimeUnit};
#[cfg(target_arch = "wasm32")]
use windfall_tree::ImportOptions;
use windfall_tree::species::GrowOptions;
use windfall_tree::{Import, Species};

/// The picture's format: egui reads it as it is, see `picture.rs`.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A forest on the GPU, and what it was made of.
pub struct World {
    /// The models and their places, on the CPU.
    pub stage: Arc<Stage>,
    /// The forest.
    pub planted: PlantedStage,
    /// Keys of the models, in the order of the stage's.
    pub keys: Vec<String>,
    /// The picture of the sky.
    pub sky: Option<SkyMap>,
    /// What there is to say about the files.
    pub notes: Vec<Note>,
    /// Leaves that have been thrown, of the scene's events.
    pub thrown: usize,
}

/// What a world is to be made of.
pub struct Request {
    /// The settings.
    pub settings: Settings,
    /// Its files.
    pub files: Files,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What was there before: equal models are taken from it.
    pub before: Option<Before>,
    /// Whether the renderer is to be made too.
    pub renderer: bool,
    /// Wakes the window.
    pub wake: Box<dyn Fn() + Send + Sync>,
}

/// What a running world gives to the next.
pub struct Before {
    /// Its stage.
    pub stage: Arc<Stage>,
    /// Its models.
    pub models: Vec<TreeModel>,
    /// Their keys.
    pub keys: Vec<String>,
}

impl Before {
    /// Where it has a model of this key.
    fn place(&self, key: &str) -> Option<usize> {
        self.keys.iter().position(|known| known == key)
    }
}

/// What a job says while it runs.
pub enum Message {
    /// The renderer.
    Renderer(Box<Renderer>),
    /// A model is there, of so many.
    Progress(String, usize, usize),
    /// The world.
    World(Box<World>),
    /// There will be none.
    Failed(String),
}

/// A job that runs beside the frames. Dropping it cancels it.
pub struct Job {
    /// What it says.
    pub messages: Receiver<Message>,
    /// What it is made of.
    pub settings: Settings,
    cancelled: Arc<AtomicBool>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// Starts a job.
pub fn start(request: Request) -> Job {
    let (sender, messages) = channel();
    let cancelled = Arc::new(AtomicBool::new(false));
    let job =
        Job { messages, settings: request.settings.clone(), cancelled: Arc::clone(&cancelled) };
    let work = Working { request, sender, cancelled };
    #[cfg(not(target_arch = "wasm32"))]
    {
        let run = move || pollster::block_on(work.run());
        let thread = std::thread::Builder::new().name("loading".to_owned()).spawn(run);
        // Without a thread the job is silent, and its dropped sender says so.
        drop(thread);
    }
    #[cfg(target_arch = "wasm32")]
    wasm_bindgen_futures::spawn_local(work.run());
    job
}

struct Working {
    request: Request,
    sender: Sender<Message>,
    cancelled: Arc<AtomicBool>,
}

impl Working {
    fn say(&self, message: Message) {
        // Nobody listens any more to a job that was cancelled.
        let _ = self.sender.send(message);
        (self.request.wake)();
    }

    async fn run(self) {
        match self.world().await {
            Ok(Some(world)) => self.say(Message::World(Box::new(world))),
            Ok(None) => {}
            Err(error) => self.say(Message::Failed(error)),
        }
    }

    /// Lets a browser draw a frame; whether to go on.
    #[cfg_attr(not(target_arch = "wasm32"), expect(clippy::unused_async, reason = "browsers wait"))]
    async fn breathe(&self) -> bool {
        #[cfg(target_arch = "wasm32")]
        crate::web::next_task().await;
        !self.cancelled.load(Ordering::Relaxed)
    }

    /// The world; `None` if it was cancelled.
    async fn world(&self) -> Result<Option<World>, String> {
        let Request { settings, files, device, queue, .. } = &self.request;
        let scene = &settings.scene;
        let wanted = scene.models();
        let keys: Vec<String> = wanted.iter().map(|model| key(model, files)).collect();
        let mut trees: Vec<Option<Tree>> = keys.iter().map(|key| self.known(key)).collect();
        let missing: Vec<usize> = (0..keys.len()).filter(|i| trees[*i].is_none()).collect();
        let sources: Vec<&Model<'_>> = missing.iter().map(|i| &wanted[*i]).collect();
        let Some(loaded) = self.load(&sources).await? else { return Ok(None) };
        let mut notes = Vec::new();
        for (i, Import { tree, notes: of_tree, .. }) in missing.into_iter().zip(loaded) {
            trees[i] = Some(tree);
            notes.extend(of_tree);
        }
        let mut stage = scene.place(trees.into_iter().flatten().collect());
        stage.check(&settings.name).map_err(text)?;
        notes.extend(fall_by(scene, files, &mut stage)?);
        if let Some(rate) = settings.throw_rate {
            stage.throw(rate, 0.0);
        }
        let sky = match &scene.sky.picture {
            None => None,
            Some(name) => {
                let picture = windfall_host::sky::parse(&files.read(name)?, name);
                Some(SkyMap::new(device, queue, &picture.map_err(|e| format!("{e:#}"))?))
            }
        };
        let mut models = Vec::new();
        for (i, tree) in stage.trees.iter().enumerate() {
            self.say(Message::Progress("onto the GPU".to_owned(), i, stage.trees.len()));
            if !self.breathe().await {
                return Ok(None);
            }
            let known = self.request.before.as_ref().and_then(|before| {
                let at = before.place(&keys[i])?;
                (before.stage.trees[at].foliage.palette == tree.foliage.palette)
                    .then(|| before.models[at].clone())
            });
            models.push(match known {
                Some(model) => model,
                None => TreeModel::new(device, queue, tree).map_err(text)?,
            });
        }
        let planted = stage.plant(device, models).map_err(text)?;
        let thrown = stage.events.len();
        Ok(Some(World { stage: Arc::new(stage), planted, keys, sky, notes, thrown }))
    }

    fn known(&self, key: &str) -> Option<Tree> {
        let before = self.request.before.as_ref()?;
        before.stage.trees.get(before.place(key)?).cloned()
    }

    fn make_renderer(&self) -> Result<(), String> {
        if self.request.renderer {
            let device = &self.request.device;
            let renderer = Renderer::new(device, &Options::picture(FORMAT)).map_err(text)?;
            self.say(Message::Renderer(Box::new(renderer)));
        }
        Ok(())
    }

    /// Makes the renderer if it is wanted, and models; `None` if it was cancelled.
    #[cfg(not(target_arch = "wasm32"))]
    #[expect(clippy::unused_async, reason = "browsers wait")]
    async fn load(&self, models: &[&Model<'_>]) -> Result<Option<Vec<Import>>, String> {
        use std::ops::ControlFlow;
        use windfall_host::tree::{TreeSource, load_all};
        let folder = &self.request.files.folder;
        let source = |model: &&Model<'_>| match model {
            Model::Species { species, seed, options } => {
                TreeSource::Species { species: *species, seed: *seed, options: *options }
            }
            Model::File { file, options } => {
                TreeSource::File { path: folder.join(file), options: options.clone() }
            }
        };
        let sources: Vec<TreeSource> = models.iter().map(source).collect();
        let begun = std::sync::Mutex::new(std::collections::BTreeSet::new());
        let watch = |i: usize, step: windfall_tree::prepare::Stage| {
            let mut begun = begun.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            begun.insert(i);
            let what = format!("{}: {}", name(models[i]), step.name());
            let _ = self.sender.send(Message::Progress(what, begun.len() - 1, models.len()));
            (self.request.wake)();
            if self.cancelled.load(Ordering::Relaxed) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let cache = windfall_host::cache::TreeCache::of_user();
        // Shaders are compiled while trees are read.
        let (loaded, made) = std::thread::scope(|scope| {
            let trees = scope.spawn(|| load_all(&sources, cache.as_ref(), &watch));
            let made = self.make_renderer();
            (trees.join(), made)
        });
        made?;
        let loaded = loaded.map_err(|_| "loading stopped; there may be too little memory")?;
        loaded.map_err(|error| format!("{error:#}"))
    }

    /// Makes the renderer if it is wanted, and models; `None` if it was cancelled.
    #[cfg(target_arch = "wasm32")]
    async fn load(&self, models: &[&Model<'_>]) -> Result<Option<Vec<Import>>, String> {
        self.say(Message::Progress("shaders".to_owned(), 0, models.len()));
        if !self.breathe().await {
            return Ok(None);
        }
        self.make_renderer()?;
        let files = &self.request.files;
        let mut trees = Vec::new();
        for model in models {
            self.say(Message::Progress(name(model).to_owned(), trees.len(), models.len()));
            if !self.breathe().await {
                return Ok(None);
            }
            trees.push(match model {
                Model::Species { species, seed, options } => {
                    match files.baked(&baked_name(*species, *seed, options)).await {
                        Some(bytes) => {
                            let options = ImportOptions::default();
                            let mut none = |_: &str| Err("nothing lies beside it".to_owned());
                            windfall_tree::import(&bytes, species.name(), &options, &mut none)
                                .map_err(text)?
                        }
                        None => species.grow_as(*seed, options).into(),
                    }
                }
                Model::File { file, options } => {
                    let mut resolve = |uri: &str| files.beside(file, uri);
                    windfall_tree::import(&files.read(file)?, file, options, &mut resolve)
                        .map_err(text)?
                }
            });
        }
        Ok(Some(trees))
    }
}

/// What the file of a baked species is called, without its ending: as `examples/page_trees.rs` writes it, and the page
/// asks for it.
pub fn baked_name(species: Species, seed: u32, options: &GrowOptions) -> String {
    // FNV-1a: the name only has to differ where the tree does.
    let key = format!("{seed} {options:?}");
    let hash = key.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{}-{hash:016x}", species.name())
}

/// A model in a word.
fn name<'a>(model: &'a Model<'_>) -> &'a str {
    match model {
        Model::Species { species, .. } => species.name(),
        Model::File { file, .. } => file.rsplit(['/', '\\']).next().unwrap_or(file),
    }
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// What a model is made of, as a text that equals that of an equal model.
fn key(model: &Model<'_>, files: &Files) -> String {
    let written = match model {
        Model::File { file, .. } => Some((files.modified(file), files.version(file))),
        Model::Species { .. } => None,
    };
    format!("{model:?} {written:?}")
}

/// Reads the paths of a scene, and lets the leaves of its stage fall by them.
fn fall_by(scene: &Scene, files: &Files, stage: &mut Stage) -> Result<Vec<Note>, String> {
    let mut notes = Vec::new();
    let mut lists = Vec::new();
    for entry in &scene.paths {
        let (paths, of_file) = read_paths(files, entry)?;
        notes.extend(of_file);
        lists.push((entry.trees.clone(), paths));
    }
    if !lists.is_empty() {
        stage.fall_by(lists).map_err(text)?;
    }
    Ok(notes)
}

/// Reads a file of fall paths.
///
/// # Errors
///
/// A sentence for people that names the file.
pub fn read_paths(
    files: &Files,
    entry: &PathEntry,
) -> Result<(Vec<windfall_core::path::FallPath>, Vec<Note>), String> {
    let bytes = files.read(&entry.file)?;
    // RON of ours begins with a parenthesis; no form that is imported does.
    if bytes.starts_with(b"WFPATHS") || bytes.trim_ascii_start().starts_with(b"(") {
        let set = windfall_flight::read_paths(&entry.file, &bytes).map_err(text)?;
        return Ok((set.paths().to_vec(), Vec::new()));
    }
    let options = windfall_flight::ImportOptions {
        node: entry.node.clone(),
        animation: entry.animation.clone(),
        up: match entry.up {
            windfall_tree::Up::Y => windfall_flight::Up::Y,
            windfall_tree::Up::Z => windfall_flight::Up::Z,
        },
        scale: entry.scale,
        time_unit: match entry.time_unit {
            TimeUnit::Seconds => windfall_flight::TimeUnit::Seconds,
            TimeUnit::Milliseconds => windfall_flight::TimeUnit::Milliseconds,
        },
        fps: entry.fps,
        rate: entry.rate,
        ..windfall_flight::ImportOptions::default()
    };
    let mut resolve = |uri: &str| files.beside(&entry.file, uri);
    let read = windfall_flight::import_with(&entry.file, &bytes, &options, &mut resolve);
    let read = read.map_err(text)?;
    Ok((vec![read.path], read.notes))
}

/// Brings a running world from one state of the settings to another, where that is possible without making it anew.
///
/// # Errors
///
/// A change that the forest refuses, in a sentence.
pub fn change(world: &mut World, settings: &Settings) -> Result<(), String> {
    let forest = &mut world.planted.forest;
    let scene = &settings.scene;
    forest.set_season(scene.season).map_err(text)?;
    let mut falls = scene.falls();
    if let Some(rate) = settings.throw_rate {
        falls.shedding = world.stage.thrown(rate, 0.0);
    }
    if falls.wind != forest.falls().wind {
        forest.set_wind(falls.wind);
    }
    if falls.shedding != forest.falls().shedding {
        forest.set_shedding(falls.shedding);
    }
    for event in &scene.events[world.thrown.min(scene.events.len())..] {
        let tree = world.planted.trees.get(event.tree as usize);
        let tree = tree.ok_or_else(|| format!("there is no tree {}", event.tree))?;
        forest.throw(*tree, event.leaf, event.time).map_err(text)?;
    }
    world.thrown = scene.events.len();
    Ok(())
}
