//! Trees from files and built-in species, ready to draw: prepared, or from the cache.
//!
//! Nothing here needs a GPU, and everything may run on a thread of its own: [`TreeSource::load`] tells how far it is, and
//! stops where it is told to.

use crate::cache::TreeCache;
use anyhow::{Context, bail};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use windfall_tree::bake::{About, BakedTree, SourceHash};
use windfall_tree::prepare::{Stage, Watch};
use windfall_tree::species::grow_watched;
use windfall_tree::{GrowOptions, Import, ImportOptions, Species, import_watched, survey};

/// What a tree is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum TreeSource {
    /// A built-in species.
    Species {
        /// Which one.
        species: Species,
        /// Its seed.
        seed: u32,
        /// How it is grown.
        options: GrowOptions,
    },
    /// A `.glb` or `.gltf` file, baked or not, and the files that it names, from its folder.
    File {
        /// Where it is.
        path: PathBuf,
        /// How it is read.
        options: ImportOptions,
    },
    /// The bytes of such a file.
    Bytes {
        /// What errors and notes call it, and the tree's name.
        name: String,
        /// The file.
        bytes: Vec<u8>,
        /// The files that it names, by the name that it has for them ([`windfall_tree::Survey::outside`]).
        outside: BTreeMap<String, Vec<u8>>,
        /// How it is read.
        options: ImportOptions,
    },
}

impl TreeSource {
    /// The species called `name`, or the tree file at that path. `seed` is for species; of `options` species take the
    /// height and the prune order.
    ///
    /// # Errors
    ///
    /// The height is not 0.01 to 1000 metres.
    pub fn named(name: &str, seed: u32, options: ImportOptions) -> anyhow::Result<Self> {
        if let Some(height) = options.height
            && !(0.01..=1000.0).contains(&height)
        {
            bail!("--height {height}: is not 0.01 to 1000 metres");
        }
        Ok(match name.parse::<Species>() {
            Ok(species) => {
                let (height, prune_order) = (options.height, options.prune_order);
                let options = GrowOptions { height, prune_order, ..GrowOptions::default() };
                Self::Species { species, seed, options }
            }
            Err(_) => Self::File { path: PathBuf::from(name), options },
        })
    }

    /// The tree, prepared for drawing: from `cache` if it is there, else made now and put there. A baked tree is read as
    /// it is. `None` if `watch` stops it; what it has done by then is lost.
    ///
    /// A cache that does not work is a warning, never an error.
    ///
    /// # Errors
    ///
    /// The file cannot be read or is not a tree; the error names the file and the place in it.
    pub fn load(
        &self,
        cache: Option<&TreeCache>,
        watch: &mut Watch<'_>,
    ) -> anyhow::Result<Option<Import>> {
        let read = self.read()?;
        let Some(cache) = cache.filter(|_| !read.baked) else {
            return self.make(&read, watch);
        };
        let source = self.hash(&read);
        if watch(Stage::Parse).is_break() {
            return Ok(None);
        }
        if let Some(BakedTree { tree, about }) = cache.get(source) {
            let mut import = Import::from(tree);
            import.notes = about.notes;
            // Of the same bytes under another name.
            if let Some(name) = &read.name {
                import.tree.name.clone_from(name);
                import.notes.iter_mut().for_each(|note| note.file.clone_from(name));
            }
            return Ok(Some(import));
        }
        let Some(import) = self.make(&read, watch)? else { return Ok(None) };
        cache.put(&import.tree, &self.about(source, &import));
        Ok(Some(import))
    }

    /// The tree, prepared now, and what a baked tree of it says about its source. `None` if `watch` stops it.
    ///
    /// # Errors
    ///
    /// As [`TreeSource::load`].
    pub fn prepare(&self, watch: &mut Watch<'_>) -> anyhow::Result<Option<(Import, About)>> {
        let read = self.read()?;
        let Some(import) = self.make(&read, watch)? else { return Ok(None) };
        let about = self.about(self.hash(&read), &import);
        Ok(Some((import, about)))
    }

    fn about(&self, source: SourceHash, import: &Import) -> About {
        let prune_order = match self {
            Self::Species { options, .. } => options.prune_order,
            Self::File { options, .. } | Self::Bytes { options, .. } => {
                let baked = import.baked.as_ref().and_then(|about| about.prune_order);
                options.prune_order.or(baked)
            }
        };
        About { source, prune_order, notes: import.notes.clone() }
    }

    /// Everything that the tree is made of; nothing is made of it.
    fn read(&self) -> anyhow::Result<Read<'_>> {
        let (name, bytes, folder, given) = match self {
            Self::Species { .. } => return Ok(Read::default()),
            Self::File { path, .. } => {
                if path.is_dir() {
                    bail!("{}: is a folder, not a tree file", path.display());
                }
                let bytes = std::fs::read(path)
                    .with_context(|| format!("{}: cannot be read", path.display()))?;
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                (path.display().to_string(), Cow::Owned(bytes), Some(folder), None)
            }
            Self::Bytes { name, bytes, outside, .. } => {
                (name.clone(), Cow::Borrowed(bytes.as_slice()), None, Some(outside))
            }
        };
        // What is no glTF at all is for the importer to say.
        let survey = survey(&bytes, &name).ok();
        let names = survey.iter().flat_map(|survey| &survey.outside);
        let outside = names.map(|name| {
            let file = match (&folder, given) {
                (Some(folder), _) => {
                    let path = folder.join(name);
                    std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))
                }
                (_, Some(given)) => {
                    given.get(name).cloned().ok_or_else(|| format!("{name}: is not there"))
                }
                _ => Err(format!("{name}: is outside")),
            };
            (name.clone(), file)
        });
        let outside = outside.collect();
        let baked = survey.as_ref().is_some_and(|survey| survey.baked);
        Ok(Read { name: Some(name), bytes, outside, baked })
    }

    /// What tells its tree from others. A file that is missing and not needed is none of it.
    fn hash(&self, read: &Read<'_>) -> SourceHash {
        match self {
            Self::Species { species, seed, options } => {
                SourceHash::of_species(*species, *seed, options)
            }
            Self::File { options, .. } | Self::Bytes { options, .. } => {
                let outside: Vec<(&str, &[u8])> = read
                    .outside
                    .iter()
                    .filter_map(|(name, file)| Some((name.as_str(), file.as_deref().ok()?)))
                    .collect();
                SourceHash::of_file(&read.bytes, &outside, options)
            }
        }
    }

    fn make(&self, read: &Read<'_>, watch: &mut Watch<'_>) -> anyhow::Result<Option<Import>> {
        match self {
            Self::Species { species, seed, options } => {
                Ok(grow_watched(&species.params(), *seed, options, watch).map(Import::from))
            }
            Self::File { options, .. } | Self::Bytes { options, .. } => {
                let mut resolve = |uri: &str| match read.outside.iter().find(|(n, _)| n == uri) {
                    Some((_, file)) => file.clone(),
                    None => Err(format!("{uri}: is not among the files that the document names")),
                };
                let name = read.name.as_deref().unwrap_or_default();
                Ok(import_watched(&read.bytes, name, options, &mut resolve, watch)?)
            }
        }
    }
}

/// The bytes of a source.
#[derive(Default)]
struct Read<'a> {
    /// What errors call the file; species have none.
    name: Option<String>,
    bytes: Cow<'a, [u8]>,
    /// Files that it names: their bytes, or why they are not there.
    outside: Vec<(String, Result<Vec<u8>, String>)>,
    baked: bool,
}

/// Grows the species called `name`, or reads the tree file at that path, without a cache: [`TreeSource::named`].
///
/// # Errors
///
/// The height is out of range, or the file cannot be read.
pub fn read_or_grow(name: &str, seed: u32, options: &ImportOptions) -> anyhow::Result<Import> {
    let loaded = TreeSource::named(name, seed, options.clone())?.load(None, &mut go_on)?;
    loaded.context("stopped")
}

/// Reads a `.glb` or `.gltf` file, and the files that it names, without a cache.
///
/// # Errors
///
/// Those of [`TreeSource::load`].
pub fn read(path: &Path, options: &ImportOptions) -> anyhow::Result<Import> {
    let source = TreeSource::File { path: path.to_owned(), options: options.clone() };
    source.load(None, &mut go_on)?.context("stopped")
}

/// Loads trees at the same time, on as many threads as the machine has cores. `watch` is told the number of the tree; when
/// it stops one, it stops all: `None`. The trees do not depend on the number of threads.
///
/// # Errors
///
/// That of the first source in order that cannot be loaded.
pub fn load_all(
    sources: &[TreeSource],
    cache: Option<&TreeCache>,
    watch: &(dyn Fn(usize, Stage) -> ControlFlow<()> + Sync),
) -> anyhow::Result<Option<Vec<Import>>> {
    let loaded: Vec<_> = sources.iter().map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(source), Some(place)) = (sources.get(i), loaded.get(i)) else { break };
            let result = source.load(cache, &mut |stage| watch(i, stage));
            let done = matches!(result, Ok(Some(_)));
            *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            if !done {
                // Those that were begun before are finished: one of them may have the first error.
                next.store(sources.len(), Ordering::Relaxed);
            }
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 1..cores.min(sources.len()) {
            scope.spawn(work);
        }
        work();
    });
    let mut trees = Vec::with_capacity(sources.len());
    let mut stopped = false;
    for place in loaded {
        match place.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(result) => match result? {
                Some(tree) => trees.push(tree),
                None => stopped = true,
            },
            None => stopped = true,
        }
    }
    Ok((!stopped).then_some(trees))
}

/// A [`Watch`] that looks away.
pub fn go_on(_: Stage) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
