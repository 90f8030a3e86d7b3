//! What a baked tree may hold: checked before it is written and after it is read.

use super::BakeError;
use glam::{Quat, Vec2, Vec3};
use windfall_core::foliage::{Foliage, Leaf, LeafShape};
use windfall_core::material::{Material, Surface};
use windfall_core::tree::{Tree, Wood};

/// What is wrong: the part of the tree and the cause.
pub(super) struct Fault {
    pub place: String,
    pub cause: String,
}

impl From<Fault> for BakeError {
    fn from(Fault { place, cause }: Fault) -> Self {
        Self::Unfit { place, cause }
    }
}

fn fault(place: impl Into<String>, cause: impl Into<String>) -> Fault {
    Fault { place: place.into(), cause: cause.into() }
}

/// Whether a value can be used.
trait Fit {
    fn fits(&self) -> bool;
}

impl Fit for f32 {
    fn fits(&self) -> bool {
        self.is_finite()
    }
}

impl Fit for Vec2 {
    fn fits(&self) -> bool {
        self.is_finite()
    }
}

impl Fit for Vec3 {
    fn fits(&self) -> bool {
        self.is_finite()
    }
}

/// The first of some values that cannot be used.
fn all<'a, T: Fit + std::fmt::Debug + 'a>(
    place: &str,
    what: &str,
    values: impl IntoIterator<Item = &'a T>,
) -> Result<(), Fault> {
    match values.into_iter().enumerate().find(|(_, value)| !value.fits()) {
        Some((i, value)) => Err(fault(place, format!("{what} {i} is {value:?}"))),
        None => Ok(()),
    }
}

fn range(place: &str, what: &str, value: f32, from: f32, to: f32) -> Result<(), Fault> {
    if value >= from && value <= to {
        Ok(())
    } else {
        Err(fault(place, format!("{what} is {value}, not {from} to {to}")))
    }
}

/// Triangles: three indices each, all of them below `count`.
fn triangles(place: &str, indices: &[u32], count: usize) -> Result<(), Fault> {
    if !indices.len().is_multiple_of(3) {
        return Err(fault(place, format!("{} indices are no triangles", indices.len())));
    }
    match indices.iter().position(|&index| index as usize >= count) {
        Some(i) => Err(fault(place, format!("index {i} is {}, of {count} vertices", indices[i]))),
        None => Ok(()),
    }
}

/// Whether `values` are as many as `count`.
fn count(place: &str, what: &str, values: usize, count: usize) -> Result<(), Fault> {
    if values == count { Ok(()) } else { Err(fault(place, format!("{values} {what} for {count}"))) }
}

/// Checks a tree as a whole. Everything that the renderer and the models take for granted holds afterwards.
pub(super) fn tree(tree: &Tree) -> Result<(), Fault> {
    wood(&tree.wood)?;
    foliage(&tree.foliage)
}

fn wood(wood: &Wood) -> Result<(), Fault> {
    let place = "wood";
    for (i, vertex) in wood.vertices.iter().enumerate() {
        let fits = vertex.position.is_finite() && vertex.uv.is_finite();
        if !fits {
            return Err(fault(place, format!("vertex {i} is not finite")));
        }
        unit("wood", "vertex", i, vertex.normal)?;
        if vertex.material as usize >= wood.materials.len() {
            let (own, all) = (vertex.material, wood.materials.len());
            return Err(fault(place, format!("vertex {i} is of material {own} of {all}")));
        }
    }
    triangles(place, &wood.indices, wood.vertices.len())?;
    count(place, "branches for vertices", wood.branches.len(), wood.vertices.len())?;
    for (i, branch) in wood.branches.iter().enumerate() {
        let fits = branch.radius.is_finite()
            && branch.radius >= 0.0
            && branch.vanishes.is_finite()
            && branch.vanishes >= 0.0;
        if !fits {
            return Err(fault(place, format!("the branch of vertex {i} is {branch:?}")));
        }
    }
    let mut error = -1.0;
    for (i, level) in wood.levels.iter().enumerate() {
        let place = format!("wood, level {i}");
        triangles(&place, &level.indices, wood.vertices.len())?;
        if !(level.error.is_finite() && level.error > error) {
            let cause = format!("its error is {}, after {error}", level.error);
            return Err(fault(place, cause));
        }
        error = level.error;
    }
    materials("wood", &wood.materials)
}

fn foliage(foliage: &Foliage) -> Result<(), Fault> {
    let place = "leaves";
    for (i, shape) in foliage.shapes.iter().enumerate() {
        leaf_shape(&format!("leaves, shape {i}"), shape)?;
    }
    let simple = &foliage.simple_shapes;
    count(place, "simple shapes for shapes", simple.len(), foliage.shapes.len())?;
    for (i, shape) in simple.iter().enumerate() {
        if let Some(shape) = shape {
            leaf_shape(&format!("leaves, simple shape {i}"), shape)?;
        }
    }
    for (i, leaf) in foliage.leaves.iter().enumerate() {
        self::leaf(foliage, i, leaf)?;
    }
    let mut seen = vec![false; foliage.leaves.len()];
    for (i, leaf) in foliage.leaves.iter().enumerate() {
        match seen.get_mut(leaf.shed_rank as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => {
                let cause =
                    format!("leaf {i} has shed rank {}, as another or none", leaf.shed_rank);
                return Err(fault(place, cause));
            }
        }
    }
    materials(place, &foliage.materials)?;
    if let Some(palette) = &foliage.palette {
        let place = "leaves, palette";
        all(place, "colour", &palette.stops)?;
        range(place, "its spread", palette.spread, 0.0, 1.0)?;
        if palette.stops.is_empty() {
            return Err(fault(place, "there are no colours"));
        }
    }
    all(place, "coordinate of the crown's centre", &foliage.crown_center.to_array())?;
    let place = "leaves, visibility";
    let seen = &foliage.visibility;
    range(place, "the share", seen.share, 0.0, 1.0)?;
    for factor in seen.disocclusion.into_iter().chain(seen.sunlight) {
        range(place, "a factor", factor, f32::MIN_POSITIVE, 1e6)?;
    }
    let place = "leaves, shading";
    all(place, "ambient", &foliage.shading.ambient.to_array())?;
    all(place, "normals", &foliage.shading.normals.to_cols_array())
}

fn leaf(foliage: &Foliage, i: usize, leaf: &Leaf) -> Result<(), Fault> {
    let fits = leaf.center.is_finite()
        && leaf.scale.is_finite()
        && leaf.scale > 0.0
        && is_unit_rotation(leaf.orientation)
        && (0.0..=1.0).contains(&leaf.ambient);
    if !fits {
        return Err(fault("leaves", format!("leaf {i} is out of range: {leaf:?}")));
    }
    unit("leaves", "leaf", i, leaf.bent_normal)?;
    for (what, index, all) in [
        ("shape", leaf.shape, foliage.shapes.len()),
        ("material", leaf.material, foliage.materials.len()),
    ] {
        if index as usize >= all {
            return Err(fault("leaves", format!("leaf {i} is of {what} {index} of {all}")));
        }
    }
    Ok(())
}

fn leaf_shape(place: &str, shape: &LeafShape) -> Result<(), Fault> {
    let vertices = shape.positions.len();
    count(place, "normals for vertices", shape.normals.len(), vertices)?;
    count(place, "texture coordinates for vertices", shape.uvs.len(), vertices)?;
    all(place, "position", &shape.positions)?;
    all(place, "texture coordinate", &shape.uvs)?;
    for (i, &normal) in shape.normals.iter().enumerate() {
        unit(place, "vertex", i, normal)?;
    }
    triangles(place, &shape.indices, vertices)
}

fn materials(place: &str, materials: &[Material]) -> Result<(), Fault> {
    for (i, material) in materials.iter().enumerate() {
        let place = format!("{place}, material {i}");
        for part in material.base_color.to_array() {
            range(&place, "its base colour", part, 0.0, 1.0)?;
        }
        range(&place, "its roughness", material.roughness, 0.0, 1.0)?;
        if let Some(cutoff) = material.alpha_cutoff {
            range(&place, "its alpha cut-off", cutoff, 0.0, 1.0)?;
        }
        match &material.surface {
            Surface::Plain => {}
            Surface::Texture(image, _) => {
                let texels = u64::from(image.width) * u64::from(image.height);
                if texels == 0 || texels * 4 != image.rgba.len() as u64 {
                    return Err(fault(place, format!("{image:?} has {} bytes", image.rgba.len())));
                }
            }
            Surface::Bark(bark) => {
                all(&place, "colour", &[bark.ridge, bark.groove])?;
                range(&place, "the size of its pattern", bark.scale, 0.0, f32::MAX)?;
            }
        }
    }
    Ok(())
}

/// Whether a normal is of length 1, within what other programs' validators take.
fn unit(place: &str, what: &str, i: usize, normal: Vec3) -> Result<(), Fault> {
    if (normal.length() - 1.0).abs() < 5e-4 {
        return Ok(());
    }
    Err(fault(place, format!("the normal of {what} {i} is {normal}, not of length 1")))
}

fn is_unit_rotation(rotation: Quat) -> bool {
    (rotation.length() - 1.0).abs() < 1e-3
}
