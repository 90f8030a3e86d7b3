//! Trees from files and built-in species.

use anyhow::{Context, bail};
use std::path::Path;
use windfall_core::tree::Tree;
use windfall_tree::{GrowOptions, ImportOptions, Species, import};

/// Grows the species called `name`, or reads the tree file at that path.
///
/// `seed` is for species only, `leaves` for files only; see [`read`]. `height` rescales the tree,
/// metres, 0.01 to 1000.
///
/// # Errors
///
/// `height` is out of range, or the file cannot be read.
pub fn read_or_grow(
    name: &str,
    seed: u32,
    leaves: &[String],
    height: Option<f32>,
) -> anyhow::Result<Tree> {
    if let Some(height) = height
        && !(0.01..=1000.0).contains(&height)
    {
        bail!("--height {height}: is not 0.01 to 1000 metres");
    }
    if let Ok(species) = name.parse::<Species>() {
        return Ok(species.grow_as(seed, &GrowOptions { height, ..GrowOptions::default() }));
    }
    read(Path::new(name), leaves, height)
}

/// Reads a `.glb` or `.gltf` file, and the files that it names, from its folder.
///
/// `leaves` names the nodes, meshes or materials that are leaves; with none the importer decides.
/// `height` rescales the tree, metres.
///
/// # Errors
///
/// The file cannot be read or is not a tree; the error names the file and the place in it.
pub fn read(path: &Path, leaves: &[String], height: Option<f32>) -> anyhow::Result<Tree> {
    if path.is_dir() {
        bail!("{}: is a folder, not a tree file", path.display());
    }
    let bytes =
        std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let options = ImportOptions { leaves: leaves.to_vec(), height, ..Default::default() };
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut resolve = |uri: &str| {
        let file = folder.join(uri);
        std::fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))
    };
    Ok(import(&bytes, &path.display().to_string(), &options, &mut resolve)?)
}
