//! Writes every composed shader module to a folder, for compilers other than naga.
//!
//!     cargo run -p windfall-gpu --example shaders -- DIR
//!     for f in DIR/*.wgsl; do tint --format wgsl -o /dev/null "$f"; done

use std::path::PathBuf;
use windfall_gpu::internals::{MODULES, Settings};

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| "shaders".into()));
    std::fs::create_dir_all(&folder)?;
    for samples in [1, 4] {
        for module in MODULES {
            let path = folder.join(format!("{}-{samples}.wgsl", module.name));
            std::fs::write(&path, (module.source)(&Settings { samples }))?;
            println!("{}", path.display());
        }
    }
    Ok(())
}
