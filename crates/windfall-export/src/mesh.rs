//! Triangles of what is exported, a mesh a material, and its pictures.

use crate::ExportError;
use crate::frame::{Kind, Source};
use glam::{Vec2, Vec3};
use windfall_core::foliage::{Foliage, LeafShape};
use windfall_core::forest::Terrain;
use windfall_core::material::{Image, Material, Surface};
use windfall_core::tree::Wood;

/// An indexed triangle mesh; as many normals as positions, as many texture coordinates or none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// `v` from 0 at the top of the picture.
    pub uvs: Vec<Vec2>,
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Smallest box around it, low and high corner.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        self.positions.iter().fold(none, |(low, high), &p| (low.min(p), high.max(p)))
    }

    pub fn of_leaf(shape: &LeafShape) -> Self {
        Self {
            positions: shape.positions.clone(),
            normals: shape.normals.clone(),
            uvs: shape.uvs.clone(),
            indices: shape.indices.clone(),
        }
    }

    /// The parts of a wood by material: the material's index, and the mesh.
    pub fn of_wood(wood: &Wood) -> Vec<(usize, Self)> {
        let mut parts = Vec::new();
        for material in 0..wood.materials.len() {
            let mut part = Self::default();
            let mut places = vec![u32::MAX; wood.vertices.len()];
            for triangle in wood.indices.chunks_exact(3) {
                if wood.vertices[triangle[0] as usize].material as usize != material {
                    continue;
                }
                for &corner in triangle {
                    let place = &mut places[corner as usize];
                    if *place == u32::MAX {
                        *place = part.positions.len() as u32;
                        let vertex = &wood.vertices[corner as usize];
                        part.positions.push(vertex.position);
                        part.normals.push(vertex.normal.normalize_or(Vec3::Y));
                        part.uvs.push(vertex.uv);
                    }
                    part.indices.push(*place);
                }
            }
            if !part.indices.is_empty() {
                parts.push((material, part));
            }
        }
        parts
    }

    /// The terrain, with the same two triangles a cell that leaves land on; level ground as far as trees stand on it.
    pub fn of_ground(source: &Source<'_>) -> Self {
        let terrain = &source.forest.terrain;
        let (low, high) = terrain.range();
        let reach = source.forest.instances.iter().map(|i| i.position.abs().max_element());
        let reach = 2.0 * (reach.fold(0.0, f32::max) + 10.0);
        // A level field may be smaller than the forest on it.
        let level = Terrain::new(2, reach, vec![low; 4]);
        let terrain = if low == high && terrain.extent() < reach { &level } else { terrain };
        let side = terrain.side();
        let mut mesh = Self::default();
        for (i, &height) in (0..).zip(terrain.heights()) {
            let at = Vec2::new((i % side) as f32, (i / side) as f32) * terrain.cell()
                - 0.5 * terrain.extent();
            mesh.positions.push(Vec3::new(at.x, height, at.y));
            mesh.normals.push(terrain.normal(at.x, at.y));
        }
        for z in 0..side - 1 {
            for x in 0..side - 1 {
                let [a, b, c, d] = [0, 1, side, side + 1].map(|offset| z * side + x + offset);
                mesh.indices.extend([a, c, b, b, c, d]);
            }
        }
        mesh
    }
}

/// The shape of a kind of leaf.
pub fn shape_of<'a>(source: &Source<'a>, kind: Kind) -> &'a LeafShape {
    &source.trees[kind.model as usize].foliage.shapes[kind.shape as usize]
}

/// The picture of a material, if it has one.
pub fn picture(material: &Material) -> Option<(&Image, bool)> {
    match &material.surface {
        Surface::Texture(image, repeat) => Some((image, *repeat)),
        Surface::Plain | Surface::Bark(_) => None,
    }
}

/// A picture as a PNG file.
pub fn encode(material: &Material, image: &Image) -> Result<Vec<u8>, ExportError> {
    let failed = |cause| ExportError::Picture { material: material.name.clone(), cause };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width, image.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&image.rgba).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// A material of leaves as other programs take it. Leaves with a palette keep a picture's light and dark and take
/// `color`, as the renderer does it; others have the picture's own colours.
pub fn leaf_material(foliage: &Foliage, material: &Material, color: Vec3) -> Material {
    let mut out = material.clone();
    if foliage.palette.is_some() {
        out.base_color = Vec3::ONE;
        if let Surface::Texture(image, _) = &mut out.surface {
            tint(image, color);
        }
    }
    out
}

/// Light and dark of a picture in one colour: its luminance over the mean of it, at most 2, times the colour.
fn tint(image: &mut Image, color: Vec3) {
    let light = |texel: &[u8]| {
        let linear = Vec3::from([0, 1, 2].map(|i| from_srgb(f32::from(texel[i]) / 255.0)));
        linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    };
    let (mut sum, mut weight) = (0.0f64, 0.0f64);
    for texel in image.rgba.chunks_exact(4) {
        let alpha = f64::from(texel[3]);
        sum += alpha * f64::from(light(texel));
        weight += alpha;
    }
    let mean = (sum / weight.max(1.0)).max(1e-4) as f32;
    for texel in image.rgba.chunks_exact_mut(4) {
        let shaded = color * (light(texel) / mean).min(2.0);
        for (byte, value) in texel.iter_mut().zip(shaded.to_array()) {
            *byte = (to_srgb(value.clamp(0.0, 1.0)) * 255.0).round() as u8;
        }
    }
}

/// A picture with its material's colour in it, for programs that do not multiply the two.
pub fn colored(material: &Material) -> Material {
    let mut out = material.clone();
    let factor = material.base_color.clamp(Vec3::ZERO, Vec3::ONE).to_array();
    if let Surface::Texture(image, _) = &mut out.surface
        && factor != [1.0; 3]
    {
        for texel in image.rgba.chunks_exact_mut(4) {
            for (byte, factor) in texel.iter_mut().zip(factor) {
                let value = from_srgb(f32::from(*byte) / 255.0) * factor;
                *byte = (to_srgb(value) * 255.0).round() as u8;
            }
        }
    }
    out
}

fn from_srgb(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn to_srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tinted_picture_keeps_its_light_and_its_holes() {
        // Black, grey, and white that is a hole: the mean is half of the grey's light.
        let rgba = vec![0, 0, 0, 255, 128, 128, 128, 255, 255, 255, 255, 0];
        let mut image = Image { width: 3, height: 1, rgba };
        tint(&mut image, Vec3::new(0.25, 0.1, 0.0));
        assert_eq!(image.rgba[..4], [0, 0, 0, 255]);
        // Twice the colour: sRGB of 0.5 and 0.2.
        assert_eq!(image.rgba[4..8], [188, 124, 0, 255]);
        assert_eq!(image.rgba[11], 0);
        for v in [0.0, 0.001, 0.2, 1.0] {
            assert!((from_srgb(to_srgb(v)) - v).abs() < 1e-5);
        }
    }
}
