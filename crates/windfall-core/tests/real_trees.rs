//! Real exports of two tools, kept beside the repository and not in it: skipped where absent.
#![expect(clippy::unwrap_used, reason = "this is test code")]

use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;
use windfall_core::glam::{Vec2, Vec3};
use windfall_core::tree::{ImportOptions, Inspection, Surface, Tree, export_glb, import};

struct Real {
    bytes: Vec<u8>,
    tree: Tree,
}

fn real(name: &str) -> Option<Real> {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/inputs/trees").join(name);
    let Ok(bytes) = std::fs::read(&path) else {
        println!("skipped: {name} is not beside the repository");
        return None;
    };
    let start = Instant::now();
    let tree = read(&bytes, name);
    println!("{:?}, {:.0} ms", Inspection::of(&tree), start.elapsed().as_secs_f64() * 1e3);
    Some(Real { bytes, tree })
}

fn read(bytes: &[u8], name: &str) -> Tree {
    import(bytes, name, &ImportOptions::default(), &mut |_| Err("no files".into())).unwrap()
}

/// Positions and texture coordinates of all leaf vertices in the tree.
fn leaf_vertices(tree: &Tree) -> impl Iterator<Item = (Vec3, Vec2)> {
    tree.foliage.leaves.iter().flat_map(|leaf| {
        let shape = &tree.foliage.shapes[leaf.shape as usize];
        shape.positions.iter().zip(&shape.uvs).map(move |(&position, &uv)| {
            (leaf.center + leaf.orientation * position * leaf.scale, uv)
        })
    })
}

/// The largest distance from a leaf vertex of the file to the nearest of the tree with the same
/// texture coordinates; infinite where there is none within `cell`.
fn reconstruction_error(real: &Real, cell: f32) -> f32 {
    let home = |p: Vec3| (p / cell).round().as_ivec3().to_array();
    let mut cells: HashMap<[i32; 3], Vec<(Vec3, Vec2)>> = HashMap::new();
    for (position, uv) in leaf_vertices(&real.tree) {
        cells.entry(home(position)).or_default().push((position, uv));
    }
    let file = gltf::Gltf::from_slice(&real.bytes).unwrap();
    let mesh =
        file.meshes().find(|m| m.primitives().any(|p| p.material().name() == Some("leaves")));
    let primitive = mesh.unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| file.blob.as_deref());
    let uvs = reader.read_tex_coords(0).unwrap().into_f32().map(Vec2::from);
    let positions = reader.read_positions().unwrap().map(Vec3::from);
    positions
        .zip(uvs)
        .map(|(position, uv)| {
            let [x, y, z] = home(position);
            (0..27)
                .filter_map(|n| cells.get(&[x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]))
                .flatten()
                .filter(|(_, other)| other.distance(uv) < 2e-3)
                .map(|(other, _)| other.distance(position))
                .fold(f32::INFINITY, f32::min)
        })
        .fold(0.0, f32::max)
}

/// Export, import: the same tree.
fn assert_round_trip(tree: &Tree) {
    let back = read(&export_glb(tree).unwrap(), &tree.name);
    let (was, is) = (Inspection::of(tree), Inspection::of(&back));
    assert_eq!((was.leaves, was.leaf_triangles), (is.leaves, is.leaf_triangles));
    assert_eq!((was.wood_triangles, was.vertices), (is.wood_triangles, is.vertices));
    assert_eq!(was.textures.len(), is.textures.len());
    let near = |a: Vec3, b: Vec3| a.distance(b) < 1e-4 * was.height_m.max(1.0);
    let (low, high) = tree.bounds();
    assert!(near(low, back.bounds().0) && near(high, back.bounds().1));
    let sorted = |tree: &Tree| {
        let mut centers: Vec<Vec3> = tree.foliage.leaves.iter().map(|l| l.center).collect();
        centers.sort_by(|a, b| a.x.total_cmp(&b.x));
        centers
    };
    // Sorted by x, rounding may swap neighbours: look a little around.
    let (a, b) = (sorted(tree), sorted(&back));
    for (i, &center) in a.iter().enumerate() {
        let around = &b[i.saturating_sub(8)..(i + 9).min(b.len())];
        assert!(around.iter().any(|&other| near(center, other)), "leaf at {center}");
    }
}

#[test]
fn cards_of_four_vertices_are_one_leaf_each() {
    for (name, leaves, wood, top, cutoff) in [
        ("oak_large_7.glb", 5280, 12_006, 100.115_57, 0.5),
        ("ash_medium_11.glb", 5440, 9120, 80.750_98, 0.5),
        // Eight triangles of 10,032 have no area.
        ("pine_medium_2.glb", 4920, 10_024, 51.294_07, 0.3),
    ] {
        let Some(real) = real(name) else { continue };
        let tree = &real.tree;
        assert_eq!(tree.foliage.leaves.len(), leaves, "{name}");
        assert_eq!(tree.foliage.triangle_count(), 2 * leaves, "{name}");
        assert_eq!(tree.wood_triangles(), wood, "{name}");
        assert!((tree.height() - top).abs() < 1e-3, "{name}: {}", tree.height());
        assert!(tree.foliage.shapes.len() <= 2, "{name}: {}", tree.foliage.shapes.len());
        let material = &tree.foliage.materials[0];
        assert_eq!(material.alpha_cutoff, Some(cutoff), "{name}");
        assert!(matches!(&material.surface, Surface::Texture(_, false)), "{name}");
        assert!(matches!(&tree.wood.materials[0].surface, Surface::Texture(_, true)), "{name}");
        // A card is some 3 to 7 units wide.
        let error = reconstruction_error(&real, 0.1);
        println!("{name}: reconstruction error {error}");
        assert!(error < 1e-3, "{name}: {error}");
    }
}

#[test]
fn a_texture_transform_is_in_the_coordinates() {
    // KHR_texture_transform of the oak's bark scales v by 0.1, and v runs from 0 to 1 in the file.
    let Some(Real { tree, .. }) = real("oak_large_7.glb") else { return };
    let v = tree.wood.vertices.iter().map(|v| v.uv.y).fold(0.0, f32::max);
    assert!((v - 0.1).abs() < 1e-6, "{v}");
}

#[test]
fn folded_leaves_with_split_midribs_are_whole() {
    let Some(real) = real("white_birch_5.glb") else { return };
    assert_eq!(real.tree.foliage.leaves.len(), 9304);
    assert_eq!(real.tree.foliage.triangle_count(), 37_216);
    assert!((real.tree.height() - 15.775_777).abs() < 1e-4, "{}", real.tree.height());
    assert!(real.tree.foliage.shapes.len() <= 4, "{}", real.tree.foliage.shapes.len());
    // A leaf is 0.15 m long.
    let error = reconstruction_error(&real, 0.002);
    println!("white_birch_5.glb: reconstruction error {error}");
    assert!(error < 1e-4, "{error}");
}

#[test]
fn real_trees_survive_export_and_import() {
    for name in ["oak_large_7.glb", "white_birch_5.glb"] {
        if let Some(real) = real(name) {
            assert_round_trip(&real.tree);
        }
    }
}

#[test]
fn tips_point_away_from_the_wood() {
    // In both tools' leaves the petiole is where the twig is: the nearest wood lies behind.
    for name in ["oak_large_7.glb", "white_birch_5.glb"] {
        let Some(Real { tree, .. }) = real(name) else { continue };
        let behind = tree.foliage.leaves.iter().step_by(97).filter(|leaf| {
            let reach = tree.foliage.shapes[leaf.shape as usize].radius() * leaf.scale;
            let [back, front] =
                [-1.0, 1.0].map(|side| leaf.center + leaf.orientation * Vec3::Z * reach * side);
            let nearest = |end: Vec3| {
                tree.wood
                    .vertices
                    .iter()
                    .map(|v| v.position.distance_squared(end))
                    .fold(f32::INFINITY, f32::min)
            };
            nearest(back) < nearest(front)
        });
        let (behind, all) = (behind.count(), tree.foliage.leaves.len().div_ceil(97));
        println!("{name}: {behind} of {all} leaves point away from the wood");
        assert!(behind * 10 > all * 8, "{name}: {behind} of {all}");
    }
}
