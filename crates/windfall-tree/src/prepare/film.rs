//! Small renders of a crown on the CPU: the nearest leaf of each pixel.
//!
//! Orthographic, one sample in the middle of each pixel, with alpha masks and without wood. Pixels are only counted:
//! a leaf covers a few in each of many directions.

use crate::parallel;
use glam::{Mat3, Vec2, Vec3};
use windfall_core::foliage::{Foliage, Leaf, LeafShape};
use windfall_core::material::Mask;

/// Pixels across the square root of a leaf's area, where a picture's size allows it.
const PIXELS_A_LEAF: f32 = 3.0;
/// Smallest and largest picture, pixels a side.
const SIZES: (f32, f32) = (96.0, 256.0);
/// No leaf.
const NONE: u32 = u32::MAX;

/// Pixels of one leaf, over all renders.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Count {
    /// Covered by the leaf, hidden or not.
    pub drawn: u32,
    /// In which the leaf is nearest.
    pub seen: u32,
}

impl Count {
    /// Pixels of all leaves, those that are drawn and those that are seen.
    pub fn sum(count: &[Self]) -> (u64, u64) {
        count
            .iter()
            .fold((0, 0), |(drawn, seen), c| (drawn + u64::from(c.drawn), seen + u64::from(c.seen)))
    }
}

/// Square renders of a crown: their size, and where the crown is in them.
pub(super) struct Film {
    size: usize,
    center: Vec3,
    /// Pixels per metre.
    scale: f32,
}

/// A render: depth and the nearest leaf of each pixel.
struct Render {
    /// Pixels a side.
    size: usize,
    depth: Vec<f32>,
    nearest: Vec<u32>,
    /// The leaf last drawn over a pixel, so that a leaf with a back side is counted once.
    last: Vec<u32>,
}

impl Film {
    /// A film on which the crown fits from every side, its leaves grown by `growth`, as fine as they need;
    /// `None` where there is nothing to see.
    pub fn around(foliage: &Foliage, growth: f32) -> Option<Self> {
        Self::with_pixels(foliage, growth, PIXELS_A_LEAF)
    }

    /// The same, as fine as a film can be.
    pub fn finest(foliage: &Foliage, growth: f32) -> Option<Self> {
        Self::with_pixels(foliage, growth, f32::INFINITY)
    }

    fn with_pixels(foliage: &Foliage, growth: f32, pixels_a_leaf: f32) -> Option<Self> {
        let leaves = &foliage.leaves;
        let radii: Vec<f32> = foliage.shapes.iter().map(LeafShape::radius).collect();
        let areas: Vec<f32> = foliage.shapes.iter().map(LeafShape::area).collect();
        let reach = |l: &Leaf| growth * l.scale * radii[l.shape as usize];
        let (low, high) = leaves.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), l| {
            (a.min(l.center), b.max(l.center))
        });
        let center = (low + high) / 2.0;
        let radius =
            leaves.iter().map(|l| l.center.distance(center) + reach(l)).fold(0.0, f32::max);
        let area = leaves.iter().map(|l| l.scale * l.scale * areas[l.shape as usize]).sum::<f32>()
            / leaves.len().max(1) as f32;
        let pixels = 2.0 * radius / area.sqrt() * pixels_a_leaf;
        if !(radius.is_finite() && radius > 0.0 && center.is_finite() && pixels > 0.0) {
            return None;
        }
        let size = pixels.clamp(SIZES.0, SIZES.1) as usize;
        Some(Self { size, center, scale: (size - 2) as f32 / (2.0 * radius) })
    }

    pub fn pixel_area(&self) -> f32 {
        1.0 / (self.scale * self.scale)
    }

    /// Pixels of each of the first `leaves`, grown by `growth`, looked at from all of `directions`.
    pub fn count(
        &self,
        foliage: &Foliage,
        leaves: usize,
        growth: f32,
        directions: &[Vec3],
    ) -> Vec<Count> {
        let counts = parallel::map(directions, |&direction| {
            let mut count = vec![Count::default(); leaves];
            let render = self.draw(foliage, growth, direction, &mut count);
            for &leaf in render.nearest.iter().filter(|&&leaf| leaf != NONE) {
                count[leaf as usize].seen += 1;
            }
            count
        });
        let mut sum = vec![Count::default(); leaves];
        for count in counts {
            for (sum, count) in sum.iter_mut().zip(count) {
                sum.drawn += count.drawn;
                sum.seen += count.seen;
            }
        }
        sum
    }

    /// What of the whole crown is seen from `side`: points of the tree, one in each pixel.
    pub fn seen_points(&self, foliage: &Foliage, side: Vec3) -> Vec<Vec3> {
        let render =
            self.draw(foliage, 1.0, side, &mut vec![Count::default(); foliage.leaves.len()]);
        let world_from_view = view_along(side).transpose();
        let middle = self.middle();
        (0..render.nearest.len())
            .filter(|&i| render.nearest[i] != NONE)
            .map(|i| {
                let pixel = Vec3::new(
                    (i % self.size) as f32 + 0.5,
                    (i / self.size) as f32 + 0.5,
                    render.depth[i],
                );
                world_from_view * (pixel - middle) / self.scale + self.center
            })
            .collect()
    }

    /// What the first `count` leaves, grown by `growth`, keep in the shade of a sun in the direction `sun`.
    pub fn shadow(&self, foliage: &Foliage, count: usize, growth: f32, sun: Vec3) -> Shadow {
        let render = self.draw(foliage, growth, sun, &mut vec![Count::default(); count]);
        Shadow {
            view: view_along(sun),
            size: self.size,
            center: self.center,
            middle: self.middle(),
            scale: self.scale,
            depth: render.depth,
        }
    }

    /// Draws as many leaves as `count` has places, grown by `growth`, looked at from `direction`, and adds to
    /// what is drawn of each.
    fn draw(&self, foliage: &Foliage, growth: f32, direction: Vec3, count: &mut [Count]) -> Render {
        let mut render = Render::new(self.size);
        let masks: Vec<Option<Mask<'_>>> = foliage.materials.iter().map(Mask::of).collect();
        let view = view_along(direction);
        let mut corners = Vec::new();
        for (i, (leaf, count)) in foliage.leaves.iter().zip(count).enumerate() {
            let shape = &foliage.shapes[leaf.shape as usize];
            let turn =
                view * Mat3::from_quat(leaf.orientation) * (leaf.scale * growth * self.scale);
            let middle = view * (leaf.center - self.center) * self.scale + self.middle();
            corners.clear();
            corners.extend(shape.positions.iter().map(|&p| middle + turn * p));
            let mask = masks.get(leaf.material as usize).and_then(Option::as_ref);
            for t in shape.indices.chunks_exact(3) {
                let t = [t[0], t[1], t[2]].map(|corner| corner as usize);
                let uvs = mask.map(|mask| (mask, t.map(|i| shape.uvs[i])));
                count.drawn += render.triangle(t.map(|i| corners[i]), uvs, i as u32);
            }
        }
        render
    }

    /// Where the middle of the crown is on the film, in pixels, with its depth in pixels towards the eye.
    fn middle(&self) -> Vec3 {
        Vec3::new(self.size as f32, self.size as f32, 0.0) / 2.0
    }
}

impl Render {
    fn new(size: usize) -> Self {
        let pixels = size * size;
        Self {
            size,
            depth: vec![f32::NEG_INFINITY; pixels],
            nearest: vec![NONE; pixels],
            last: vec![NONE; pixels],
        }
    }

    /// Draws a triangle of a leaf; the pixels that the leaf had not covered before.
    fn triangle(
        &mut self,
        [a, b, c]: [Vec3; 3],
        mask: Option<(&Mask<'_>, [Vec2; 3])>,
        leaf: u32,
    ) -> u32 {
        let [p, q, r] = [a, b, c].map(Vec3::truncate);
        // Pixels whose middles lie within its box: of a small triangle often none.
        let end = self.size as i32;
        // (The cast rounds towards 0, much faster than `floor` on machines of the plainest kind.)
        let first = |low: f32| ((low + 0.5) as i32).max(0);
        let last = |high: f32| ((high + 0.5) as i32).min(end);
        let low = p.min(q).min(r);
        let high = p.max(q).max(r);
        let (xs, ys) = (first(low.x)..last(high.x), first(low.y)..last(high.y));
        let area = (q - p).perp_dot(r - p);
        if xs.is_empty() || ys.is_empty() || area == 0.0 {
            return 0;
        }
        let per_area = 1.0 / area;
        let mut fresh = 0;
        for y in ys {
            for x in xs.clone() {
                let at = Vec2::new(x as f32, y as f32) + 0.5;
                let u = (r - q).perp_dot(at - q) * per_area;
                let v = (p - r).perp_dot(at - r) * per_area;
                let w = 1.0 - u - v;
                // Of no use are pixels outside, nor those of a triangle too thin for its area.
                if !(u >= 0.0 && v >= 0.0 && w >= 0.0) {
                    continue;
                }
                if let Some((mask, [s, t, o])) = mask
                    && !mask.covers(s * u + t * v + o * w)
                {
                    continue;
                }
                let pixel = (y * end + x) as usize;
                fresh += u32::from(std::mem::replace(&mut self.last[pixel], leaf) != leaf);
                let depth = a.z * u + b.z * v + c.z * w;
                if depth > self.depth[pixel] {
                    self.depth[pixel] = depth;
                    self.nearest[pixel] = leaf;
                }
            }
        }
        fresh
    }
}

/// The depths of a crown, as the sun sees it.
pub(super) struct Shadow {
    view: Mat3,
    size: usize,
    center: Vec3,
    middle: Vec3,
    scale: f32,
    depth: Vec<f32>,
}

impl Shadow {
    /// Pixels towards the sun up to which leaves do not shade what lies behind them: as the texels of
    /// `leaf_radiance` in `leaves.wgsl`. A tree that is simplified is far away, where those are about as large
    /// as pixels of a finest film.
    const BIAS: f32 = 1.5;

    /// Whether the sun reaches a point of the tree.
    pub fn lit(&self, point: Vec3) -> bool {
        let at = self.view * (point - self.center) * self.scale + self.middle;
        let inside = |x: f32| x >= 0.0 && x < self.size as f32;
        !(inside(at.x) && inside(at.y))
            || self.depth[at.y as usize * self.size + at.x as usize] <= at.z + Self::BIAS
    }
}

/// From the tree to a film that looks against `direction`: right, up, towards the eye.
fn view_along(direction: Vec3) -> Mat3 {
    let (right, up) = direction.any_orthonormal_pair();
    Mat3::from_cols(right, up, direction).transpose()
}
