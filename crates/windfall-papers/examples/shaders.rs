//! Writes every composed shader module of the published strategies to a folder, for compilers other than naga.
//!
//!     cargo run -p windfall-papers --example shaders -- DIR
//!     for f in DIR/*.wgsl; do tint --format wgsl -o /dev/null "$f"; done

use std::path::PathBuf;
use windfall_gpu::internals::{SAMPLES, Settings};
use windfall_papers::MODULES;

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| "shaders".into()));
    std::fs::create_dir_all(&folder)?;
    for module in MODULES {
        let path = folder.join(format!("{}.wgsl", module.name));
        std::fs::write(&path, (module.source)(&Settings { samples: SAMPLES }))?;
        println!("{}", path.display());
    }
    Ok(())
}
