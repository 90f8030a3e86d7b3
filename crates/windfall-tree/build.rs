//! Fingerprint of the code that prepares trees, for the keys of caches: trees that another version has prepared may
//! differ. In the repository it is a hash of the sources of this crate and of windfall-core, in a package the version.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};

fn main() {
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut hasher = DefaultHasher::new();
    std::env::var("CARGO_PKG_VERSION").unwrap_or_default().hash(&mut hasher);
    for folder in [own.join("src"), own.join("../windfall-core/src")] {
        // A published package has no neighbours.
        if folder.is_dir() {
            println!("cargo::rerun-if-changed={}", folder.display());
            add(&folder, &mut hasher).expect("the sources can be read");
        }
    }
    println!("cargo::rustc-env=WINDFALL_PREPARATION={:016x}", hasher.finish());
}

/// Adds the files of a folder and of those in it, by name.
fn add(folder: &Path, hasher: &mut DefaultHasher) -> io::Result<()> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort();
    for path in entries {
        path.file_name().hash(hasher);
        if path.is_dir() {
            add(&path, hasher)?;
        } else {
            std::fs::read(&path)?.hash(hasher);
        }
    }
    Ok(())
}
