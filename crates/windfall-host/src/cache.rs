//! The cache of trees that programs have baked themselves.
//!
//! A folder of baked trees, one file each, named by a hash of what the tree is made of and of the code that prepared
//! it. Programs write beside and rename, so that several at once leave whole files. A cache is a help and never a
//! need: what goes wrong with it is a warning.

use crate::file::write_atomic;
use anyhow::Context;
use std::fs::{DirEntry, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};
use tracing::{info, warn};
use windfall_core::tree::Tree;
use windfall_tree::bake::{About, PREPARATION, SourceHash, VERSION, Viewers};
use windfall_tree::{BakedTree, bake};

/// Temporary files this old are of programs that have ended.
const STALE: Duration = Duration::from_hours(1);

/// A folder of baked trees.
#[derive(Debug)]
pub struct TreeCache {
    folder: PathBuf,
    most_bytes: u64,
    /// Whether it cannot be read or written: said once.
    broken: AtomicBool,
}

/// A tree in the cache.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CachedTree {
    /// Its file.
    pub path: PathBuf,
    /// Size of the file.
    pub bytes: u64,
    /// When it was last written or read.
    pub used: SystemTime,
}

impl TreeCache {
    /// Bytes that a cache may have, unless another limit is given.
    pub const MOST_BYTES: u64 = 1 << 30;

    /// The user's cache: the folder that the environment variable `WINDFALL_CACHE_DIR` names, else `windfall/trees` in
    /// the user's cache folder. `None` where a user has none.
    pub fn of_user() -> Option<Self> {
        let named = std::env::var_os("WINDFALL_CACHE_DIR").filter(|name| !name.is_empty());
        let folder = match named {
            Some(named) => PathBuf::from(named),
            None => dirs::cache_dir()?.join("windfall").join("trees"),
        };
        Some(Self::at(folder, Self::MOST_BYTES))
    }

    /// The cache in a folder, which need not be there yet, of at most `most_bytes` bytes.
    pub fn at(folder: PathBuf, most_bytes: u64) -> Self {
        Self { folder, most_bytes, broken: AtomicBool::new(false) }
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its limit, bytes.
    pub fn most_bytes(&self) -> u64 {
        self.most_bytes
    }

    /// The tree of a source, if it is there, and marks it as used. A file that cannot be read as a baked tree is
    /// removed.
    pub fn get(&self, source: SourceHash) -> Option<BakedTree> {
        if self.broken.load(Ordering::Relaxed) {
            return None;
        }
        let path = self.path(source);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            Err(error) => {
                self.give_up(&format!("{}: {error}", path.display()));
                return None;
            }
        };
        let read = BakedTree::read(&bytes, &path.display().to_string());
        match read {
            Ok(baked) if baked.about.source == source => {
                // The oldest go first; a folder that cannot be written keeps all.
                let touched = File::options()
                    .append(true)
                    .open(&path)
                    .and_then(|f| f.set_modified(SystemTime::now()));
                if let Err(error) = touched {
                    info!("{} cannot be marked as used: {error}", path.display());
                }
                info!("a baked tree from the cache: {}", path.display());
                return Some(baked);
            }
            Ok(_) => warn!("{}: is of another source; it is baked again", path.display()),
            Err(error) => warn!("{error}; it is baked again"),
        }
        // Another program may have removed or replaced it: either will do.
        let _ = std::fs::remove_file(&path);
        None
    }

    /// Puts a prepared tree into the cache, and removes the oldest until its limit is kept. What fails is a warning,
    /// the first time.
    pub fn put(&self, tree: &Tree, about: &About) {
        if self.broken.load(Ordering::Relaxed) {
            return;
        }
        match self.try_put(tree, about) {
            Ok(path) => info!("baked a tree into the cache: {}", path.display()),
            Err(error) => self.give_up(&format!("{error:#}")),
        }
    }

    /// Says once that the cache is of no use.
    fn give_up(&self, why: &str) {
        if !self.broken.swap(true, Ordering::Relaxed) {
            warn!("the tree cache is not used: {why}");
        }
    }

    fn try_put(&self, tree: &Tree, about: &About) -> anyhow::Result<PathBuf> {
        let bytes = bake(tree, about, Viewers::Wood)
            .with_context(|| format!("the tree {:?} cannot be baked", tree.name))?;
        let path = self.path(about.source);
        write_atomic(&path, |file| Ok(file.write_all(&bytes)?))?;
        self.shrink().with_context(|| format!("{}", self.folder.display()))?;
        Ok(path)
    }

    /// What is in the cache, the most recently used first.
    ///
    /// # Errors
    ///
    /// The folder is there and cannot be read.
    pub fn trees(&self) -> io::Result<Vec<CachedTree>> {
        let mut trees = Vec::new();
        for entry in self.files()? {
            if entry.path().extension().is_none_or(|e| e != "glb") || !is_hash(&entry.path()) {
                continue;
            }
            // Another program may remove it at any time.
            let Ok(metadata) = entry.metadata() else { continue };
            let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            trees.push(CachedTree { path: entry.path(), bytes: metadata.len(), used });
        }
        trees.sort_by(|a, b| b.used.cmp(&a.used).then_with(|| a.path.cmp(&b.path)));
        Ok(trees)
    }

    /// Removes all trees; their number and bytes. Other files in the folder stay.
    ///
    /// # Errors
    ///
    /// A file cannot be removed.
    pub fn clear(&self) -> io::Result<(usize, u64)> {
        let trees = self.trees()?;
        for tree in &trees {
            remove(&tree.path)?;
        }
        self.remove_stale(Duration::ZERO)?;
        Ok((trees.len(), trees.iter().map(|tree| tree.bytes).sum()))
    }

    fn path(&self, source: SourceHash) -> PathBuf {
        let key = format!("{source} {VERSION} {PREPARATION}");
        self.folder.join(format!("{}.glb", blake3::hash(key.as_bytes()).to_hex()))
    }

    /// Removes the oldest trees beyond the limit, and what programs that were killed have left.
    fn shrink(&self) -> io::Result<()> {
        let mut bytes = 0;
        for tree in self.trees()? {
            bytes += tree.bytes;
            if bytes > self.most_bytes {
                remove(&tree.path)?;
            }
        }
        self.remove_stale(STALE)
    }

    fn remove_stale(&self, age: Duration) -> io::Result<()> {
        for entry in self.files()? {
            let temporary = entry.file_name().to_string_lossy().starts_with(".windfall-");
            let old = || entry.metadata().ok()?.modified().ok()?.elapsed().ok().map(|a| a >= age);
            if temporary && old() == Some(true) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }

    /// What is in the folder; nothing if it is not there.
    fn files(&self) -> io::Result<Vec<DirEntry>> {
        match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries.collect(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(error),
        }
    }
}

/// Removes a file that another program may remove at the same time.
fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Whether a file is named by a hash.
fn is_hash(path: &Path) -> bool {
    path.file_stem()
        .and_then(|name| name.to_str())
        .is_some_and(|name| name.len() == 64 && name.bytes().all(|b| b.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_tree::{GrowOptions, LeafCount, Species};

    fn grown(seed: u32) -> (Tree, About) {
        let options = GrowOptions { leaves: LeafCount::Exactly(40), ..GrowOptions::default() };
        let source = SourceHash::of_species(Species::Aspen, seed, &options);
        (
            Species::Aspen.grow_as(seed, &options),
            About { source, prune_order: None, notes: Vec::new() },
        )
    }

    #[test]
    fn a_tree_comes_back_from_the_cache_and_from_no_other_source() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TreeCache::at(folder.path().join("new"), TreeCache::MOST_BYTES);
        let ((tree, about), (_, other)) = (grown(1), grown(2));
        assert!(cache.get(about.source).is_none());
        assert!(cache.trees().unwrap().is_empty());
        cache.put(&tree, &about);
        let read = cache.get(about.source).unwrap();
        assert_eq!(format!("{:?}", read.tree), format!("{tree:?}"));
        assert_eq!(read.about, about);
        assert!(cache.get(other.source).is_none());
    }

    #[test]
    fn a_damaged_tree_is_removed_and_baked_again() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TreeCache::at(folder.path().to_owned(), TreeCache::MOST_BYTES);
        let ((tree, about), (_, other)) = (grown(1), grown(2));
        cache.put(&tree, &about);
        let path = cache.path(about.source);
        let bytes = std::fs::read(&path).unwrap();
        // As if another tree had its name.
        std::fs::write(cache.path(other.source), &bytes).unwrap();
        assert!(cache.get(other.source).is_none());
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(cache.get(about.source).is_none());
        assert!(cache.trees().unwrap().is_empty(), "both are gone");
        cache.put(&tree, &about);
        assert!(cache.get(about.source).is_some());
    }

    #[test]
    fn the_oldest_go_where_there_is_no_room_and_what_is_not_its_own_stays() {
        let folder = tempfile::tempdir().unwrap();
        let trees = [1, 2, 3].map(grown);
        let all = TreeCache::at(folder.path().to_owned(), TreeCache::MOST_BYTES);
        std::fs::write(folder.path().join("notes.glb"), b"mine").unwrap();
        for (i, (tree, about)) in trees.iter().enumerate() {
            all.put(tree, about);
            let file = File::options().append(true).open(all.path(about.source)).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(i as u64)).unwrap();
        }
        let sizes: Vec<u64> = all.trees().unwrap().iter().map(|tree| tree.bytes).collect();
        // Reading the oldest makes it the newest; then the second is too much.
        assert!(all.get(trees[0].1.source).is_some());
        let few = TreeCache::at(folder.path().to_owned(), sizes.iter().sum::<u64>() - 1);
        few.put(&trees[0].0, &trees[0].1);
        let there = trees.each_ref().map(|(_, about)| few.path(about.source).exists());
        assert_eq!(there, [true, false, true]);
        let (count, bytes) = few.clear().unwrap();
        assert_eq!(count, 2);
        assert!(bytes > 0 && few.trees().unwrap().is_empty());
        assert!(folder.path().join("notes.glb").exists());
        // No room for a single tree: it is not kept, and nothing fails.
        let none = TreeCache::at(folder.path().to_owned(), 1);
        none.put(&trees[0].0, &trees[0].1);
        assert!(none.trees().unwrap().is_empty() && !none.broken.load(Ordering::Relaxed));
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_failure() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a file");
        std::fs::write(&file, b"").unwrap();
        let cache = TreeCache::at(file.join("trees"), TreeCache::MOST_BYTES);
        let (tree, about) = grown(1);
        cache.put(&tree, &about);
        assert!(cache.broken.load(Ordering::Relaxed));
        cache.put(&tree, &about);
        assert!(cache.get(about.source).is_none());
    }

    #[test]
    fn temporary_files_of_programs_that_were_killed_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TreeCache::at(folder.path().to_owned(), TreeCache::MOST_BYTES);
        let [old, new] =
            [".windfall-a.glb", ".windfall-b.glb"].map(|name| folder.path().join(name));
        std::fs::write(&new, b"half").unwrap();
        let file = File::create(&old).unwrap();
        file.set_modified(SystemTime::now() - 2 * STALE).unwrap();
        let (tree, about) = grown(1);
        cache.put(&tree, &about);
        assert!(!old.exists() && new.exists());
    }
}
