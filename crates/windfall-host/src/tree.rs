//! Trees from files and built-in species.

use anyhow::{Context, bail};
use std::path::Path;
use windfall_tree::{GrowOptions, Import, ImportOptions, Species, import};

/// Grows the species called `name`, or reads the tree file at that path.
///
/// `seed` is for species only; of `options` species take the height alone, 0.01 to 1000 metres. See [`read`].
///
/// # Errors
///
/// The height is out of range, or the file cannot be read.
pub fn read_or_grow(name: &str, seed: u32, options: &ImportOptions) -> anyhow::Result<Import> {
    if let Some(height) = options.height
        && !(0.01..=1000.0).contains(&height)
    {
        bail!("--height {height}: is not 0.01 to 1000 metres");
    }
    if let Ok(species) = name.parse::<Species>() {
        let grow = GrowOptions { height: options.height, ..GrowOptions::default() };
        return Ok(species.grow_as(seed, &grow).into());
    }
    read(Path::new(name), options)
}

/// Reads a `.glb` or `.gltf` file, and the files that it names, from its folder.
///
/// # Errors
///
/// The file cannot be read or is not a tree; the error names the file and the place in it.
pub fn read(path: &Path, options: &ImportOptions) -> anyhow::Result<Import> {
    if path.is_dir() {
        bail!("{}: is a folder, not a tree file", path.display());
    }
    let bytes =
        std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut resolve = |uri: &str| {
        let file = folder.join(uri);
        std::fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))
    };
    Ok(import(&bytes, &path.display().to_string(), options, &mut resolve)?)
}
