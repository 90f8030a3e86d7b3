//! Whole trees as two kinds of tools export them, made here: cards with a texture of leaves, and leaves of polygons
//! whose midribs are split. What goes in is known, so what is read is compared with it.

mod common;

use common::{Model, png};
use serde_json::json;
use windfall_core::glam::{Quat, Vec2, Vec3};
use windfall_core::rng::Rng;
use windfall_core::tree::Tree;
use windfall_tree::{Inspection, export_glb, import};

/// A leaf as it is put into the file.
struct Placed {
    petiole: Vec3,
    orientation: Quat,
    scale: f32,
}

/// A leaf of a kind of tree: vertices with texture coordinates, +Y up, the petiole at the origin, the tip at +Z.
struct Kind {
    corners: &'static [([f32; 3], [f32; 2])],
    triangles: &'static [u16],
}

/// A card, 6 units wide and 8 long.
const CARD: Kind = Kind {
    corners: &[
        ([-3.0, 0.0, 0.0], [0.0, 1.0]),
        ([3.0, 0.0, 0.0], [1.0, 1.0]),
        ([3.0, 0.0, 8.0], [1.0, 0.0]),
        ([-3.0, 0.0, 8.0], [0.0, 0.0]),
    ],
    triangles: &[0, 2, 1, 0, 3, 2],
};

/// A leaf of 15 cm, folded along its midrib, whose vertices each half has of its own.
///
/// ```text
///      2 5        tip
///     /| |\
///    0 | | 3      the halves rise towards their edges
///     \| |/
///      1 4        petiole
/// ```
const FOLDED: Kind = Kind {
    corners: &[
        ([-0.05, 0.02, 0.07], [0.0, 0.5]),
        ([0.0, 0.0, 0.0], [0.5, 0.0]),
        ([0.0, 0.0, 0.15], [0.5, 1.0]),
        ([0.05, 0.02, 0.07], [1.0, 0.5]),
        ([0.0, 0.0, 0.0], [0.5, 0.0]),
        ([0.0, 0.0, 0.15], [0.5, 1.0]),
    ],
    triangles: &[0, 2, 1, 3, 4, 5],
};

const LEAVES: usize = 400;

/// A trunk, and limbs as strips along their length, `size` long, with a leaf at every tenth of each, whose tips point away from it.
fn tree(kind: &Kind, size: f32, edit: impl FnOnce(&mut Model)) -> (Model, Vec<Placed>) {
    let mut rng = Rng::new(7);
    // A trunk at the origin, so that the tree stands where it is.
    let mut wood: Vec<[f32; 3]> = [(-0.01, 0.0), (0.01, 0.0), (-0.01, 2.0), (0.01, 2.0)]
        .map(|(x, y)| [x * size, y * size, 0.0])
        .to_vec();
    let (mut triangles, mut placed) = (vec![0u16, 1, 2, 2, 1, 3], Vec::new());
    for limb in 0..LEAVES / 10 {
        let turn = Quat::from_rotation_y(2.4 * limb as f32);
        let foot = Vec3::Y * size * (0.5 + 0.05 * limb as f32);
        let along = turn * Vec3::new(0.96, 0.28, 0.0);
        for step in 0..=10u16 {
            let at = foot + along * (size * f32::from(step) / 10.0);
            let aside = turn * Vec3::Z * (0.01 * size);
            wood.extend([(at - aside).to_array(), (at + aside).to_array()]);
            if step > 0 {
                let b = wood.len() as u16 - 4;
                triangles.extend([b, b + 1, b + 2, b + 2, b + 1, b + 3]);
                let tip = Quat::from_axis_angle(along, rng.range(0.0, 6.3)) * (turn * Vec3::Z);
                let up = Quat::from_axis_angle(tip, rng.range(0.0, 6.3)) * along;
                let axes = windfall_core::glam::Mat3::from_cols(up.cross(tip), up, tip);
                placed.push(Placed {
                    petiole: at,
                    orientation: Quat::from_mat3(&axes),
                    scale: rng.range(0.7, 1.3),
                });
            }
        }
    }
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for leaf in &placed {
        let base = positions.len() as u16;
        for &(corner, uv) in kind.corners {
            let at = leaf.petiole + leaf.orientation * Vec3::from(corner) * leaf.scale;
            positions.push(at.to_array());
            uvs.push(uv);
        }
        indices.extend(kind.triangles.iter().map(|i| base + i));
    }
    let mut model = Model::tree();
    let (wood, triangles) = (model.floats(&wood), model.shorts(&triangles));
    model.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(wood);
    model.json["meshes"][0]["primitives"][0]["indices"] = json!(triangles);
    let (positions, uvs) = (model.floats(&positions), model.floats(&uvs));
    let indices = model.shorts(&indices);
    model.leaves()["attributes"] = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
    model.leaves()["indices"] = json!(indices);
    edit(&mut model);
    (model, placed)
}

fn cards() -> (Model, Vec<Placed>) {
    tree(&CARD, 60.0, |model| {
        model.texture(&png());
        model.json["materials"][1]["alphaCutoff"] = json!(0.3);
        model.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33071 }]);
        model.json["textures"][0]["sampler"] = json!(0);
    })
}

fn folded() -> (Model, Vec<Placed>) {
    tree(&FOLDED, 2.0, |_| {})
}

/// Each leaf of the file has one leaf of the tree, with every vertex in its place and its tip where it was.
fn assert_is_made_of(tree: &Tree, kind: &Kind, placed: &[Placed], tolerance: f32) {
    assert_eq!(tree.foliage.leaves.len(), placed.len());
    assert_eq!(tree.foliage.triangle_count(), placed.len() * kind.triangles.len() / 3);
    assert_eq!(tree.foliage.shapes.len(), 1, "all are alike but for size, place and turn");
    let mut taken = vec![false; placed.len()];
    for leaf in &tree.foliage.leaves {
        let shape = &tree.foliage.shapes[leaf.shape as usize];
        let at = |i: usize| leaf.center + leaf.orientation * shape.positions[i] * leaf.scale;
        // The tree's vertices in the order of the triangles: found again by their texture coordinates.
        let off = |from: &Placed| {
            let corners = kind.corners.iter().map(|&(corner, uv)| {
                let expected = from.petiole + from.orientation * Vec3::from(corner) * from.scale;
                (0..shape.uvs.len())
                    .filter(|&i| shape.uvs[i].distance(Vec2::from(uv)) < 2e-3)
                    .map(|i| at(i).distance(expected))
                    .fold(f32::INFINITY, f32::min)
            });
            corners.fold(0.0, f32::max)
        };
        let from = (0..placed.len()).find(|&i| !taken[i] && off(&placed[i]) < tolerance);
        let from = from.unwrap_or_else(|| panic!("a leaf at {} is of no leaf", leaf.center));
        taken[from] = true;
        let tip = (leaf.orientation * Vec3::Z).dot(placed[from].orientation * Vec3::Z);
        assert!(tip > 0.99, "the tip of the leaf at {} points back to the wood", leaf.center);
    }
}

#[test]
fn cards_are_one_leaf_each() {
    let (model, placed) = cards();
    let tree = model.import().unwrap();
    assert_is_made_of(&tree, &CARD, &placed, 1e-3);
    assert_eq!(tree.foliage.materials[0].alpha_cutoff, Some(0.3));
    assert_eq!(tree.wood_triangles(), 2 * LEAVES + 2);
}

#[test]
fn folded_leaves_with_split_midribs_are_whole() {
    let (model, placed) = folded();
    assert_is_made_of(&model.import().unwrap(), &FOLDED, &placed, 1e-5);
}

/// Export, import: the same tree.
#[test]
fn made_trees_survive_export_and_import() {
    for ((model, placed), kind, tolerance) in [(cards(), CARD, 2e-3), (folded(), FOLDED, 2e-5)] {
        let tree = model.import().unwrap();
        let bytes = export_glb(&tree).unwrap();
        let back =
            import(&bytes, "tree.glb", &windfall_tree::ImportOptions::default(), &mut |_| {
                Err("no files".into())
            });
        let back = back.unwrap().tree;
        assert_is_made_of(&back, &kind, &placed, tolerance);
        let (was, is) = (Inspection::of(&tree), Inspection::of(&back));
        assert_eq!((was.wood_triangles, was.vertices), (is.wood_triangles, is.vertices));
        assert_eq!(was.textures.len(), is.textures.len());
        let near = |a: Vec3, b: Vec3| a.distance(b) < 1e-4 * was.height_m;
        assert!(near(tree.bounds().0, back.bounds().0) && near(tree.bounds().1, back.bounds().1));
    }
}
