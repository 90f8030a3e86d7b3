//! Assets: tree models and sets of fall paths.

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use bevy::tasks::AsyncComputeTaskPool;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use windfall::flight::read_paths;
use windfall::path::PathSet;
use windfall::tree::{ImportOptions, Species, Tree, Up, import};
use windfall::{InputError, Note};

/// A tree: wood and leaves, prepared for drawing. One model stands any number of times in any number of forests.
///
/// Loaded from `.glb` and `.gltf` files, baked (`windfall bake`) or plain. A baked tree loads in milliseconds; a plain
/// one is prepared on a background task, which takes seconds.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_windfall::{TreeModel, TreeSettings};
/// # fn load(assets: Res<AssetServer>) {
/// let oak: Handle<TreeModel> = assets.load("oak.baked.glb");
/// let birch: Handle<TreeModel> = assets
///     .load_builder()
///     .with_settings(|tree: &mut TreeSettings| tree.height = Some(14.0))
///     .load("birch.glb");
/// # }
/// ```
#[derive(Asset, TypePath, Debug, Clone)]
pub struct TreeModel {
    /// The tree.
    pub tree: Arc<Tree>,
    /// What was left out of the file, repaired, or looks wrong.
    pub notes: Vec<Note>,
}

impl TreeModel {
    /// A tree of a built-in species with `leaves` leaves, whose size makes up for their number; some 3,000 to 20,000
    /// are usual. The same arguments give the same tree. Takes seconds: call it on a task where that matters.
    pub fn grow(species: Species, seed: u32, leaves: u32) -> Self {
        species.grow_with(seed, leaves).into()
    }
}

impl From<Tree> for TreeModel {
    fn from(tree: Tree) -> Self {
        Self { tree: Arc::new(tree), notes: Vec::new() }
    }
}

/// How a tree file is read: `windfall::tree::ImportOptions`, as settings of the loader. A baked tree takes `height` only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TreeSettings {
    /// Nodes to read, by name or number, with all that is below them; empty: the whole scene.
    pub node: Vec<String>,
    /// Nodes, meshes or materials that are leaves; empty: those that are named so or are alpha-masked.
    pub leaves: Vec<String>,
    /// The same that are wood.
    pub wood: Vec<String>,
    /// Whether Z points up in the file.
    pub z_up: bool,
    /// Metres for each unit of the file; `None`: 1.
    pub unit: Option<f32>,
    /// Put the lowest point on the ground.
    pub ground: bool,
    /// Whether colours of vertices multiply those of materials; on by default.
    pub vertex_colors: bool,
    /// Height to scale the tree to, metres.
    pub height: Option<f32>,
    /// Seed of the shed order and of a random prune order.
    pub seed: u32,
}

impl Default for TreeSettings {
    fn default() -> Self {
        Self {
            node: Vec::new(),
            leaves: Vec::new(),
            wood: Vec::new(),
            z_up: false,
            unit: None,
            ground: false,
            vertex_colors: true,
            height: None,
            seed: 0,
        }
    }
}

impl TreeSettings {
    fn options(&self) -> ImportOptions {
        let Self { node, leaves, wood, z_up, unit, ground, vertex_colors, height, seed } =
            self.clone();
        let up = if z_up { Up::Z } else { Up::Y };
        ImportOptions {
            node,
            leaves,
            wood,
            up,
            unit,
            ground,
            vertex_colors,
            height,
            seed,
            prune_order: None,
        }
    }
}

/// Why a tree, a path set or a scene was not loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {cause}")]
    Read {
        /// The file.
        file: String,
        /// The reader's words.
        cause: String,
    },
    /// The file is not what it should be; names the place in it and the cause.
    #[error(transparent)]
    Input(#[from] InputError),
}

/// Loads [`TreeModel`]s.
#[derive(Debug, Default, TypePath)]
pub struct TreeLoader;

impl AssetLoader for TreeLoader {
    type Asset = TreeModel;
    type Settings = TreeSettings;
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &TreeSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<TreeModel, LoadError> {
        let file = context.path().to_string();
        let bytes = read(reader, &file).await?;
        read_tree(bytes, file, settings.options(), context).await
    }

    fn extensions(&self) -> &[&str] {
        &["glb", "gltf"]
    }
}

/// A tree from the bytes of its file. What the file names outside itself is fetched first, as the reader of trees waits
/// for nothing.
pub(crate) async fn read_tree(
    bytes: Vec<u8>,
    file: String,
    options: ImportOptions,
    context: &mut LoadContext<'_>,
) -> Result<TreeModel, LoadError> {
    let mut outside = BTreeMap::new();
    for name in windfall::tree::survey(&bytes, &file)?.outside {
        let found = match context.path().resolve_embed_str(&name) {
            Ok(path) => context.read_asset_bytes(path).await.map_err(|e| e.to_string()),
            Err(e) => Err(e.to_string()),
        };
        outside.insert(name, found);
    }
    // Preparing a plain tree would hold up the files of others.
    let made = AsyncComputeTaskPool::get().spawn(async move {
        let mut resolve = |name: &str| {
            let missing = || Err(format!("{name} is not named by the file"));
            outside.get(name).cloned().unwrap_or_else(missing)
        };
        import(&bytes, &file, &options, &mut resolve)
    });
    let made = made.await?;
    for note in &made.notes {
        info!("{note}");
    }
    Ok(TreeModel { tree: Arc::new(made.tree), notes: made.notes })
}

/// Paths by which leaves fall: a file that `windfall paths` or `windfall::flight` wrote. The built-in ones need none.
#[derive(Asset, TypePath, Debug, Clone)]
pub struct FallPaths(pub PathSet);

/// Loads [`FallPaths`], in binary form (`.paths`) or as text (`.paths.ron`).
#[derive(Debug, Default, TypePath)]
pub struct PathLoader;

impl AssetLoader for PathLoader {
    type Asset = FallPaths;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<FallPaths, LoadError> {
        let file = context.path().to_string();
        let bytes = read(reader, &file).await?;
        Ok(FallPaths(read_paths(&file, &bytes)?))
    }

    fn extensions(&self) -> &[&str] {
        &["paths", "paths.ron"]
    }
}

pub(crate) async fn read(reader: &mut dyn Reader, file: &str) -> Result<Vec<u8>, LoadError> {
    let mut bytes = Vec::new();
    match reader.read_to_end(&mut bytes).await {
        Ok(_) => Ok(bytes),
        Err(e) => Err(LoadError::Read { file: file.to_owned(), cause: e.to_string() }),
    }
}
