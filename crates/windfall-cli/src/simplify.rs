//! `windfall simplify`: a tree with a share of its leaves, as plain glTF.

use crate::loading::{self, CacheArgs};
use crate::reading::{ReadArgs, print_notes};
use anyhow::{Context, bail};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use windfall_core::simplify::{PruneOrder, WoodLevel};
use windfall_core::tree::Tree;
use windfall_host::file::write_atomic;
use windfall_host::tree::TreeSource;
use windfall_tree::{export_glb, export_glb_in_prune_order, set_prune_order};

/// Arguments of `windfall simplify`.
#[derive(clap::Args)]
pub struct Args {
    /// A .glb or .gltf file, or the name of a species
    #[arg(value_name = "FILE|SPECIES")]
    tree: String,
    /// Share of the leaves that is kept, above 0, at most 1
    #[arg(long, value_name = "SHARE", required_unless_present = "all_in_order")]
    lambda: Option<f32>,
    /// Which leaves are kept: the first in this order: random, importance or blue-noise
    #[arg(long, value_name = "NAME", default_value_t)]
    prune_order: PruneOrder,
    /// Leave the leaves that are kept as large as they are
    #[arg(long)]
    no_area_preservation: bool,
    /// Trunk and branches: simplified (to the same share), full or none
    #[arg(long, value_name = "HOW", default_value = "simplified")]
    wood: WoodAs,
    /// Keep all leaves, in prune order and as many indices each, so that another program can draw
    /// any prefix; the primitive's `extras` say how
    #[arg(long, conflicts_with_all = ["lambda", "no_area_preservation"])]
    all_in_order: bool,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Key of everything random
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Print one JSON object of what was kept
    #[arg(long)]
    json: bool,
    /// File to write
    #[arg(long, value_name = "FILE.glb")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum WoodAs {
    Simplified,
    Full,
    None,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    prune_order: String,
    lambda: f32,
    leaves: usize,
    leaves_full: usize,
    leaf_triangles: usize,
    leaf_triangles_full: usize,
    /// `r` of equation 3.
    visible_share: f32,
    /// Factors on `s` of equation 3 at 1/4, 1/16 and 1/64 of the leaves.
    disocclusion: [f32; 3],
    /// Factor on the length of the leaves that are kept.
    growth: f32,
    wood_triangles: usize,
    wood_triangles_full: usize,
    wood_error_m: f32,
    bytes: usize,
}

/// Runs `windfall simplify`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let lambda = args.lambda.unwrap_or(1.0);
    if !(lambda > 0.0 && lambda <= 1.0) {
        bail!("--lambda {lambda}: is not a share above 0 and at most 1");
    }
    if same_file(Path::new(&args.tree), &args.out) {
        bail!("--out {}: is the file that is read", args.out.display());
    }
    if !args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
        bail!("--out {}: is not a .glb file", args.out.display());
    }
    let source = TreeSource::named(&args.tree, args.seed, args.read.options(&[]))?;
    let read = loading::load(&[source], args.cache.cache().as_ref())?.pop().context("a tree")?;
    print_notes(&read.notes);
    let mut tree = read.tree;
    let (leaves_full, wood_triangles_full) = (tree.foliage.leaves.len(), tree.wood_triangles());
    let leaf_triangles_full = tree.foliage.triangle_count();
    set_prune_order(&mut tree.foliage, args.prune_order, args.seed);
    let seen = tree.foliage.visibility;
    let leaves = ((lambda * leaves_full as f32).round() as usize).clamp(1, leaves_full.max(1));
    let lambda = leaves as f32 / leaves_full.max(1) as f32;
    let growth = if args.no_area_preservation || args.all_in_order {
        1.0
    } else {
        seen.area_scale(lambda).sqrt()
    };
    tree.foliage.truncate(leaves);
    for leaf in &mut tree.foliage.leaves {
        leaf.scale *= growth;
    }
    let wood_error_m = simplify_wood(&mut tree, args.wood, lambda);
    let bytes =
        if args.all_in_order { export_glb_in_prune_order(&tree) } else { export_glb(&tree) }?;
    write_atomic(&args.out, |file| Ok(file.write_all(&bytes)?))?;
    if args.json {
        let report = Report {
            prune_order: args.prune_order.to_string(),
            lambda,
            leaves,
            leaves_full,
            leaf_triangles: tree.foliage.triangle_count(),
            leaf_triangles_full,
            visible_share: seen.share,
            disocclusion: seen.disocclusion,
            growth,
            wood_triangles: tree.wood_triangles(),
            wood_triangles_full,
            wood_error_m,
            bytes: bytes.len(),
        };
        writeln!(std::io::stdout(), "{}", serde_json::to_string_pretty(&report)?)?;
    }
    Ok(())
}

/// Brings the wood to the level nearest to `share` of its triangles; its error, metres.
fn simplify_wood(tree: &mut Tree, wood: WoodAs, share: f32) -> f32 {
    match wood {
        WoodAs::Full => 0.0,
        WoodAs::None => {
            tree.wood.indices.clear();
            0.0
        }
        WoodAs::Simplified => {
            let target = share * tree.wood.indices.len().max(1) as f32;
            let off = |level: &WoodLevel| (level.indices.len().max(1) as f32 / target).ln().abs();
            let levels = tree.wood.levels.iter().enumerate();
            let nearest = levels.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
            let Some((nearest, &WoodLevel { error, .. })) = nearest else { return 0.0 };
            tree.wood = tree.wood.baked(nearest);
            error
        }
    }
}

pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
