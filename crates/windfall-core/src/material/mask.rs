//! Textures with holes, as on leaf cards.

use super::{Image, Material, Surface};
use glam::Vec2;

/// The holes that a texture leaves in the cards that carry it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Holes {
    /// Share of a card that is not a hole, `0..=1`.
    pub solid: f32,
    /// Side of the pieces between holes, relative to the card's, `0..=1`.
    pub piece: f32,
}

impl Holes {
    /// None.
    pub const NONE: Self = Self { solid: 1.0, piece: 1.0 };
}

impl Material {
    /// The holes in its texture; [`Holes::NONE`] for a material without an alpha cut-off.
    pub fn holes(&self) -> Holes {
        Mask::of(self).map_or(Holes::NONE, |mask| mask.holes())
    }
}

/// Alpha test of a texture: texels less opaque than the material's cut-off are holes.
#[derive(Debug, Clone, Copy)]
pub struct Mask<'a> {
    image: &'a Image,
    repeat: bool,
    /// In units of a byte of alpha.
    cutoff: f32,
}

impl<'a> Mask<'a> {
    /// `None` for a material without holes.
    pub fn of(material: &'a Material) -> Option<Self> {
        match (&material.surface, material.alpha_cutoff) {
            (Surface::Texture(image, repeat), Some(cutoff)) => {
                Some(Self { image, repeat: *repeat, cutoff: cutoff * 255.0 })
            }
            _ => None,
        }
    }

    /// Whether the texel at these texture coordinates is drawn.
    pub fn covers(&self, uv: Vec2) -> bool {
        let uv = if self.repeat { uv - uv.floor() } else { uv };
        let texel = |x: f32, n: u32| ((x * n as f32).max(0.0) as u32).min(n - 1) as usize;
        self.drawn(texel(uv.x, self.image.width), texel(uv.y, self.image.height))
    }

    fn drawn(&self, x: usize, y: usize) -> bool {
        f32::from(self.image.rgba[4 * (y * self.image.width as usize + x) + 3]) >= self.cutoff
    }

    /// Measures the holes: the side of a piece is the geometric mean of its mean run lengths along rows
    /// and along columns.
    pub fn holes(&self) -> Holes {
        let (width, height) = (self.image.width as usize, self.image.height as usize);
        let (mut drawn, mut runs_across, mut runs_along) = (0u32, 0u32, 0u32);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            if self.drawn(x, y) {
                drawn += 1;
                runs_across += u32::from(x == 0 || !self.drawn(x - 1, y));
                runs_along += u32::from(y == 0 || !self.drawn(x, y - 1));
            }
        }
        let mean = |runs: u32, all: usize| drawn as f32 / (runs.max(1) as f32 * all as f32);
        Holes {
            solid: drawn as f32 / (width * height) as f32,
            piece: (mean(runs_across, width) * mean(runs_along, height)).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn material(width: u32, height: u32, alpha: &[u8], cutoff: Option<f32>) -> Material {
        let rgba = alpha.iter().flat_map(|&a| [9, 9, 9, a]).collect();
        Material {
            name: String::new(),
            base_color: Vec3::ONE,
            roughness: 1.0,
            alpha_cutoff: cutoff,
            surface: Surface::Texture(Image { width, height, rgba }, false),
        }
    }

    #[test]
    fn pieces_are_what_holes_leave() {
        let whole = material(2, 2, &[200; 4], Some(0.5));
        assert_eq!(whole.holes(), Holes::NONE);
        // Of four columns the first and the last two: 1 and 2 of 4 across, all along.
        let columns = material(4, 2, &[200, 0, 200, 200, 200, 0, 200, 200], Some(0.5));
        assert_eq!(columns.holes(), Holes { solid: 0.75, piece: (1.5f32 / 4.0).sqrt() });
        let rows = material(2, 4, &[200, 200, 0, 0, 200, 200, 200, 200], Some(0.5));
        assert_eq!(rows.holes(), columns.holes());
        let nothing = material(2, 1, &[0, 100], Some(0.5));
        assert_eq!(nothing.holes(), Holes { solid: 0.0, piece: 0.0 });
        assert_eq!(material(1, 1, &[0], None).holes(), Holes::NONE);
    }

    #[test]
    fn places_beyond_the_picture_are_its_edge() {
        let half = material(2, 1, &[255, 0], Some(0.5));
        let mask = Mask::of(&half).unwrap();
        let covers = |x: f32| mask.covers(Vec2::new(x, 0.5));
        assert_eq!([-1.0, 0.4, 0.6, 2.0].map(covers), [true, true, false, false]);
    }
}
