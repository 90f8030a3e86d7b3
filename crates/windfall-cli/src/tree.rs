//! `windfall tree`: tree files.

use anyhow::Context;
use std::io::Write;
use std::path::PathBuf;
use windfall_core::tree::Tree;
use windfall_host::file::write_atomic;
use windfall_host::tree::read_or_grow;
use windfall_tree::{Inspection, Species, export_glb};

/// Arguments of `windfall tree`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Print what a tree file or a species is made of
    Inspect {
        /// A .glb or .gltf file, or the name of a species
        #[arg(value_name = "FILE|SPECIES")]
        tree: String,
        /// Name of a node, mesh or material that is leaves; may be given again
        #[arg(long, value_name = "NAME")]
        leaves: Vec<String>,
        /// Rescale to this height, metres
        #[arg(long, value_name = "M")]
        height: Option<f32>,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Write a built-in species as a .glb file
    Export {
        /// Name of the species
        species: String,
        /// Key of everything random
        #[arg(long, default_value_t = 0)]
        seed: u32,
        /// File to write
        #[arg(long, value_name = "FILE.glb")]
        out: PathBuf,
    },
}

/// Runs `windfall tree`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    match &args.command {
        Command::Inspect { tree, leaves, height, json } => {
            let tree = read_or_grow(tree, 0, leaves, *height)?;
            inspect(&tree, *json)
        }
        Command::Export { species, seed, out } => {
            let species: Species = species.parse().map_err(|e| anyhow::anyhow!("{e}"))?;
            let bytes = export_glb(&species.grow(*seed))?;
            write_atomic(out, |file| Ok(file.write_all(&bytes)?))
        }
    }
}

fn inspect(tree: &Tree, json: bool) -> anyhow::Result<()> {
    let facts = Inspection::of(tree);
    let bytes_gpu = windfall_gpu::model_bytes(tree);
    let mut out = std::io::stdout().lock();
    let mut object = serde_json::to_value(&facts)?;
    object["bytes_gpu"] = bytes_gpu.into();
    if json {
        writeln!(out, "{}", serde_json::to_string_pretty(&object)?)?;
        return Ok(());
    }
    let fields = object.as_object().context("an inspection is an object")?;
    for (name, value) in fields {
        let value = match value {
            serde_json::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        writeln!(out, "{name:<15} {value}")?;
    }
    Ok(())
}
