//! `windfall tree`: tree files.

mod inspect;
mod picture;

use crate::reading::{ReadArgs, print_notes};
use std::io::Write;
use std::path::PathBuf;
use windfall_host::file::write_atomic;
use windfall_host::tree::read_or_grow;
use windfall_tree::{Species, export_glb};

/// Arguments of `windfall tree`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Print what a tree file or a species is made of, and what each primitive is taken for
    Inspect {
        /// A .glb or .gltf file, or the name of a species
        #[arg(value_name = "FILE|SPECIES")]
        tree: String,
        #[command(flatten)]
        read: Box<ReadArgs>,
        /// What is wood: as for --leaves
        #[arg(long, value_name = "NAME|N")]
        wood: Vec<String>,
        /// Draw the tree as it was read, leaves orange and wood blue, from two sides
        #[arg(long, value_name = "FILE.png")]
        picture: Option<PathBuf>,
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
        Command::Inspect { tree, read, wood, picture, json } => {
            let read = read_or_grow(tree, 0, &read.options(wood))?;
            print_notes(&read.notes);
            if let Some(path) = picture {
                picture::draw(&read.tree).save_png(path)?;
            }
            inspect::print(&read, *json)
        }
        Command::Export { species, seed, out } => {
            let species: Species = species.parse().map_err(|e| anyhow::anyhow!("{e}"))?;
            let bytes = export_glb(&species.grow(*seed))?;
            write_atomic(out, |file| Ok(file.write_all(&bytes)?))
        }
    }
}
