//! One measurement, in a process of its own: its memory is nobody else's.

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use windfall_gpu::TreeModel;
use windfall_host::device::{Gpu, NoAdapter};
use windfall_host::memory;
use windfall_host::tree::{TreeSource, go_on};
use windfall_tree::bake::Viewers;
use windfall_tree::{ImportOptions, bake};

/// What a process measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Task {
    /// The `gltf` crate reads the file, its buffers and its pictures.
    Gltf,
    /// Windfall reads and prepares the file, and bakes it.
    Bake,
    /// Windfall reads the baked file and uploads the tree.
    Baked,
}

/// What it found.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Found {
    /// Milliseconds by what took them.
    pub ms: BTreeMap<String, f64>,
    /// Most memory over that before, bytes: of loading, and of loading and uploading.
    pub peak: Option<u64>,
    pub peak_uploaded: Option<u64>,
    /// Leaves and triangles of wood.
    pub leaves: usize,
    pub wood_triangles: usize,
}

impl Found {
    fn add(&mut self, what: &str, since: Instant) {
        *self.ms.entry(what.to_owned()).or_default() += since.elapsed().as_secs_f64() * 1e3;
    }
}

/// Runs a task in a process of its own. `out` is the baked file, which [`Task::Bake`] writes.
pub fn run(task: Task, file: &Path, out: &Path) -> anyhow::Result<Found> {
    let task = clap::ValueEnum::to_possible_value(&task).context("a task has a name")?;
    let program = std::env::current_exe().context("the program does not know itself")?;
    let mut command = Command::new(program);
    command.args(["bench", "load", "--task", task.get_name()]).arg(file).arg("--out").arg(out);
    let output = command.output().context("the program cannot be started")?;
    if !output.status.success() {
        bail!("{}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// The task, in this process; prints what it found.
pub fn be(task: Task, file: &Path, out: &Path) -> anyhow::Result<()> {
    let found = match task {
        Task::Gltf => with_gltf(file)?,
        Task::Bake => baking(file, out)?,
        Task::Baked => baked(out)?,
    };
    Ok(writeln!(std::io::stdout(), "{}", serde_json::to_string(&found)?)?)
}

/// Most memory over that of `before`.
fn over(before: Option<u64>) -> Option<u64> {
    Some(memory::peak()?.saturating_sub(before?))
}

/// Begins to measure memory.
fn begin() -> Option<u64> {
    if memory::reset_peak() { memory::resident() } else { None }
}

fn with_gltf(file: &Path) -> anyhow::Result<Found> {
    let mut found = Found::default();
    let before = begin();
    let start = Instant::now();
    let imported = gltf::import(file).with_context(|| format!("{}", file.display()))?;
    found.add("gltf crate", start);
    found.peak = over(before);
    // Windfall's parsing gives arrays; the crate's import alone gives the bytes in which they are.
    let (document, buffers, _) = &imported;
    let mut arrays = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data[..]));
        arrays.0.extend(reader.read_positions().into_iter().flatten());
        arrays.1.extend(reader.read_normals().into_iter().flatten());
        arrays.2.extend(
            reader
                .read_tex_coords(0)
                .into_iter()
                .flat_map(gltf::mesh::util::ReadTexCoords::into_f32),
        );
        arrays.3.extend(
            reader.read_indices().into_iter().flat_map(gltf::mesh::util::ReadIndices::into_u32),
        );
    }
    std::hint::black_box(&arrays);
    found.add("gltf crate, with its arrays", start);
    Ok(found)
}

fn source(path: &Path) -> TreeSource {
    let path = PathBuf::from(path);
    let prune_order = Some((Default::default(), ImportOptions::PRUNE_SEED));
    TreeSource::File { path, options: ImportOptions { prune_order, ..ImportOptions::default() } }
}

fn baking(file: &Path, out: &Path) -> anyhow::Result<Found> {
    let mut found = Found::default();
    let before = begin();
    let start = Instant::now();
    let mut stage: Option<(&str, Instant)> = None;
    let prepared = source(file).prepare(&mut |next| {
        if let Some((name, since)) = stage.replace((next.name(), Instant::now())) {
            found.add(name, since);
        }
        ControlFlow::Continue(())
    })?;
    let (import, about) = prepared.context("stopped")?;
    if let Some((name, since)) = stage {
        found.add(name, since);
    }
    let writing = Instant::now();
    let bytes = bake(&import.tree, &about, Viewers::Everything)?;
    std::fs::write(out, bytes).with_context(|| format!("{}", out.display()))?;
    found.add("write", writing);
    found.add("bake", start);
    found.peak = over(before);
    found.leaves = import.tree.foliage.leaves.len();
    found.wood_triangles = import.tree.wood_triangles();
    Ok(found)
}

fn baked(file: &Path) -> anyhow::Result<Found> {
    let mut found = Found::default();
    // The adapter is there before trees are loaded; without one, nothing is uploaded.
    let gpu = match Gpu::open() {
        Ok(gpu) => Some(gpu),
        Err(error) if error.is::<NoAdapter>() => None,
        Err(error) => return Err(error),
    };
    let before = begin();
    let start = Instant::now();
    let import = source(file).load(None, &mut go_on)?.context("stopped")?;
    found.add("load baked", start);
    found.peak = over(before);
    if let Some(gpu) = gpu {
        let uploading = Instant::now();
        let model = TreeModel::new(&gpu.device, &gpu.queue, &import.tree)?;
        gpu.queue.submit([]);
        gpu.wait()?;
        found.add("upload", uploading);
        found.add("ready to draw", start);
        found.peak_uploaded = over(before);
        drop(model);
    }
    Ok(found)
}
