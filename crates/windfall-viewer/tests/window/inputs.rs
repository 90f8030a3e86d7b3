//! Files of each kind, and files that are none.

use std::path::Path;
use windfall_tree::Species;

/// Writes them into the folder in which the window runs.
pub fn write(folder: &Path) {
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    put("birch.glb", &windfall_tree::export_glb(&Species::Birch.grow_with(5, 900)).unwrap());
    put("bad.glb", b"glTF, or so it says");
    // A leaf that goes down by a metre a second, a row each tenth.
    let rows = (0..30).map(|i| {
        let t = f64::from(i) * 0.1;
        format!("{t},{},{},0,0,0,0,1\n", 0.2 * (3.0 * t).sin(), -t)
    });
    let table: String = std::iter::once("t,x,y,z,qx,qy,qz,qw\n".to_owned()).chain(rows).collect();
    put("fall.csv", table.as_bytes());
    put("bad.csv", b"t,x,y\n0,zero,0\n");
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    sky.extend((0..32).flat_map(|i| [90, 110, 160 + i, 128]));
    put("sky.hdr", &sky);
    put("bad.hdr", b"#?RADIANCE\nand no more");
    let mut scene = windfall_scenes::named("lone-oak").unwrap();
    scene.season = 0.25;
    put("mine.ron", scene.to_ron().as_bytes());
    put("bad.ron", b"(version: 1, season: \"late\")");
}
