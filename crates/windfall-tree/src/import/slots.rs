//! Materials of the tree: one for each of the file's and for each use, and for each colour that vertices give it.

use super::Reader;
use super::material::Look;
use crate::leaves::Mesh;
use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::InputError;
use windfall_core::material::{Image, Material, Surface};

/// Most colours that vertices may give to one material: more are brought together. Each has a texture of its own.
const MOST_COLORS: usize = 32;
const MOST_COLORS_OF_TEXTURES: usize = 4;

/// A material of the file, and whether leaves have it: a material may dress both wood and leaves.
type Dress = (Option<usize>, bool);

/// The materials so far, and which of them is for what.
#[derive(Default)]
pub(super) struct Slots {
    looks: BTreeMap<Option<usize>, Look>,
    colors: BTreeMap<Dress, Colors>,
    numbers: BTreeMap<(Dress, [u8; 3]), u32>,
    pub leaves: Vec<Material>,
    pub wood: Vec<Material>,
}

/// Colours that vertices give to a material, in sRGB.
struct Colors {
    all: BTreeSet<[u8; 3]>,
    most: usize,
    /// Steps of a channel, once they are counted.
    steps: Option<u32>,
}

impl Slots {
    /// A material of the file.
    pub fn look(
        &mut self,
        reader: &mut Reader<'_>,
        material: Option<usize>,
        place: &str,
    ) -> Result<Look, InputError> {
        if let Some(look) = self.looks.get(&material) {
            return Ok(look.clone());
        }
        let look = reader.look(material, place)?;
        self.looks.insert(material, look.clone());
        Ok(look)
    }

    /// Announces a colour that a material will have: all of them before the first [`Self::slot`].
    pub fn announce(&mut self, dress: Dress, color: Vec3) {
        let textured = self
            .looks
            .get(&dress.0)
            .is_some_and(|look| matches!(look.material.surface, Surface::Texture(..)));
        let most = if textured { MOST_COLORS_OF_TEXTURES } else { MOST_COLORS };
        let entry = Colors { all: BTreeSet::new(), most, steps: None };
        let colors = self.colors.entry(dress).or_insert(entry);
        // Beyond some thousands it is clear that they are to be brought together.
        if colors.all.len() < 1 << 16 {
            colors.all.insert(srgb(color));
        }
    }

    /// The number of a material in the list of the leaves or of the wood, times a colour.
    pub fn slot(&mut self, dress: Dress, color: Vec3) -> u32 {
        let color = match self.colors.get_mut(&dress) {
            Some(colors) => colors.nearest(srgb(color)),
            None => [255; 3],
        };
        let list = if dress.1 { &mut self.leaves } else { &mut self.wood };
        *self.numbers.entry((dress, color)).or_insert_with(|| {
            if let Some(look) = self.looks.get(&dress.0) {
                let mut material = look.material.clone();
                material.base_color *= Vec3::from(color.map(linear));
                list.push(material);
            }
            list.len() as u32 - 1
        })
    }

    /// What a look comes down to: its cut-off and its picture.
    pub fn known(&self, material: Option<usize>) -> Option<&Material> {
        self.looks.get(&material).map(|look| &look.material)
    }

    /// Mean colour of a mesh of a material: by area, of picture, factor and vertices.
    pub fn mean_color(&self, material: Option<usize>, mesh: &Mesh) -> Vec3 {
        let Some(material) = self.known(material) else { return Vec3::ONE };
        let (mut sum, mut all) = (Vec3::ZERO, 0.0);
        for (triangle, area) in mesh.indices.chunks_exact(3).zip(mesh.area_vectors()) {
            let corners = [triangle[0], triangle[1], triangle[2]].map(|i| i as usize);
            let uv = corners.map(|i| mesh.uvs[i]).iter().sum::<Vec2>() / 3.0;
            let color = match &material.surface {
                Surface::Texture(image, _) => texel(image, uv),
                Surface::Plain | Surface::Bark(_) => Vec3::ONE,
            };
            sum += color * mesh.mean_color(triangle) * area.length();
            all += area.length();
        }
        material.base_color * if all > 0.0 { sum / all } else { Vec3::ONE }
    }

    /// The number of a plain material of leaves.
    pub fn plain(&mut self, of: Option<usize>, color: Vec3) -> u32 {
        let color = srgb(color).map(|c| (c / 8 * 8).saturating_add(4));
        let base_color = Vec3::from(color.map(linear));
        let known = self.leaves.iter().position(|material| {
            matches!(material.surface, Surface::Plain) && material.base_color == base_color
        });
        if let Some(known) = known {
            return known as u32;
        }
        let name = self.looks.get(&of).map_or_else(|| "leaves".into(), |l| l.material.name.clone());
        self.leaves.push(Material {
            name,
            base_color,
            roughness: 0.9,
            alpha_cutoff: None,
            surface: Surface::Plain,
        });
        self.leaves.len() as u32 - 1
    }
}

impl Colors {
    fn nearest(&mut self, color: [u8; 3]) -> [u8; 3] {
        let (all, most) = (&self.all, self.most);
        let steps = *self.steps.get_or_insert_with(|| {
            let few = |steps: u32| {
                let rounded = all.iter().map(|&color| round(color, steps));
                rounded.collect::<BTreeSet<_>>().len() <= most
            };
            [255, 127, 63, 31, 15, 7, 5, 3, 2].into_iter().find(|&steps| few(steps)).unwrap_or(1)
        });
        round(color, steps)
    }
}

fn round(color: [u8; 3], steps: u32) -> [u8; 3] {
    color.map(|c| {
        let step = (u32::from(c) * steps + 127) / 255;
        ((step * 255 + steps / 2) / steps) as u8
    })
}

fn srgb(color: Vec3) -> [u8; 3] {
    color.to_array().map(|c| {
        let c = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (c.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

/// The colour of a picture, repeated.
fn texel(image: &Image, uv: Vec2) -> Vec3 {
    let uv = uv - uv.floor();
    let at = |x: f32, n: u32| ((x * n as f32) as u32).min(n - 1) as usize;
    let first = 4 * (at(uv.y, image.height) * image.width as usize + at(uv.x, image.width));
    Vec3::from([0, 1, 2].map(|i| linear(image.rgba[first + i])))
}

/// A byte of sRGB as a linear number.
pub(super) fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_colours_are_brought_together() {
        let all: BTreeSet<[u8; 3]> = (0..=255u8).map(|i| [i, 255 - i, 9]).collect();
        let mut colors = Colors { all: all.clone(), most: 32, steps: None };
        let kept: BTreeSet<_> = all.iter().map(|&c| colors.nearest(c)).collect();
        assert!((9..=32).contains(&kept.len()), "{}", kept.len());
        for &color in &all {
            let near = colors.nearest(color);
            assert!(
                color.iter().zip(near).all(|(&a, b)| a.abs_diff(b) <= 10),
                "{color:?} {near:?}"
            );
        }
        // A few stay as they are.
        let few: BTreeSet<[u8; 3]> = [[1, 2, 3], [200, 100, 50]].into();
        let mut colors = Colors { all: few.clone(), most: 32, steps: None };
        assert!(few.iter().all(|&color| colors.nearest(color) == color));
    }

    #[test]
    fn bytes_go_through_linear_and_back() {
        for byte in 0..=255 {
            assert_eq!(srgb(Vec3::splat(linear(byte))), [byte; 3]);
        }
    }
}
