//! A tree as it was read, in two colours: what is leaves and what is wood, seen from the front and from above one
//! corner. Drawn on the CPU, so that it needs no graphics adapter.

use windfall_core::glam::{Quat, Vec2, Vec3};
use windfall_core::material::Mask;
use windfall_core::tree::Tree;
use windfall_host::image::RgbaImage;

/// Side of one view, pixels; drawn twice as large.
const SIDE: usize = 512;
const SAMPLES: usize = 2;
/// Room around the tree, as a part of the view.
const MARGIN: f32 = 0.06;
const BACKGROUND: Vec3 = Vec3::new(0.93, 0.94, 0.95);
const LEAVES: Vec3 = Vec3::new(0.92, 0.47, 0.06);
const WOOD: Vec3 = Vec3::new(0.16, 0.27, 0.55);
const GROUND: Vec3 = Vec3::new(0.55, 0.58, 0.6);

/// An image with its pixels.
pub struct Drawn {
    width: usize,
    height: usize,
    rgba: Vec<u8>,
}

impl Drawn {
    pub fn save_png(&self, path: &std::path::Path) -> anyhow::Result<()> {
        let (width, height) = (self.width as u32, self.height as u32);
        RgbaImage { width, height, rgba: &self.rgba }.save_png(path)
    }
}

/// Draws a tree from the front (looking along -Z) and from a corner above, at one scale. A line shows the ground,
/// and marks on the left edge metres (tens of metres, where there are many).
pub fn draw(tree: &Tree) -> Drawn {
    let (low, high) = tree.bounds();
    let (low, high) = (low.min(Vec3::ZERO.with_x(low.x).with_z(low.z)), high);
    let corner = Quat::from_rotation_x(0.5) * Quat::from_rotation_y(0.8);
    let views = [Quat::IDENTITY, corner].map(|turn| View::of(turn, low, high));
    let scale = views.iter().map(|view| view.size).fold(f32::MIN_POSITIVE, f32::max);
    let mut rgba = vec![255; SIDE * SIDE * 2 * 4];
    for (i, view) in views.iter().enumerate() {
        let mut canvas = Canvas::new(view, scale);
        canvas.ground(low, high);
        canvas.tree(tree);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let color = canvas.pixel(x, y).to_array().map(|c| (c * 255.0).round() as u8);
                let at = 4 * (y * SIDE * 2 + i * SIDE + x);
                rgba[at..at + 3].copy_from_slice(&color);
            }
        }
    }
    Drawn { width: SIDE * 2, height: SIDE, rgba }
}

/// A parallel view: X to the right, Y up, Z towards the eye.
struct View {
    turn: Quat,
    middle: Vec3,
    size: f32,
}

impl View {
    fn of(turn: Quat, low: Vec3, high: Vec3) -> Self {
        let corners = (0..8).map(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
            turn * Vec3::new(pick(0), pick(1), pick(2))
        });
        let (from, to) =
            corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = to - from;
        Self { turn, middle: (from + to) / 2.0, size: size.x.max(size.y) }
    }
}

struct Canvas<'a> {
    view: &'a View,
    scale: f32,
    colors: Vec<Vec3>,
    depths: Vec<f32>,
}

impl<'a> Canvas<'a> {
    const SIDE: usize = SIDE * SAMPLES;

    fn new(view: &'a View, size: f32) -> Self {
        let count = Self::SIDE * Self::SIDE;
        let scale = Self::SIDE as f32 * (1.0 - 2.0 * MARGIN) / size;
        Self {
            view,
            scale,
            colors: vec![BACKGROUND; count],
            depths: vec![f32::NEG_INFINITY; count],
        }
    }

    /// Where a point is: pixels to the right and down, and nearness to the eye.
    fn place(&self, point: Vec3) -> Vec3 {
        let p = (self.view.turn * point - self.view.middle) * self.scale;
        let half = Self::SIDE as f32 / 2.0;
        Vec3::new(half + p.x, half - p.y, p.z)
    }

    /// The ground, and marks of the height.
    fn ground(&mut self, low: Vec3, high: Vec3) {
        let (a, b) = (low.with_y(0.0), high.with_y(0.0));
        let corners = [a, Vec3::new(b.x, 0.0, a.z), b, Vec3::new(a.x, 0.0, b.z)];
        for i in 0..4 {
            self.line(corners[i], corners[(i + 1) % 4]);
        }
        let step = if high.y > 40.0 { 10.0 } else { 1.0 };
        let mut height = 0.0;
        while height <= high.y && self.view.turn == Quat::IDENTITY {
            let y = self.place(Vec3::Y * height).y.round() as usize;
            for x in 0..Self::SIDE / 40 {
                self.dot(x, y.min(Self::SIDE - 1), 0.0);
            }
            height += step;
        }
    }

    fn line(&mut self, a: Vec3, b: Vec3) {
        let steps = 2 * Self::SIDE;
        for i in 0..=steps {
            let p = self.place(a.lerp(b, i as f32 / steps as f32));
            if p.x >= 0.0 && p.y >= 0.0 {
                self.dot(p.x as usize, p.y as usize, p.z);
            }
        }
    }

    fn dot(&mut self, x: usize, y: usize, depth: f32) {
        if x < Self::SIDE && y < Self::SIDE && depth > self.depths[y * Self::SIDE + x] {
            self.colors[y * Self::SIDE + x] = GROUND;
            self.depths[y * Self::SIDE + x] = depth;
        }
    }

    fn tree(&mut self, tree: &Tree) {
        let wood = &tree.wood;
        let masks: Vec<Option<Mask<'_>>> = wood.materials.iter().map(Mask::of).collect();
        for t in wood.indices.chunks_exact(3) {
            let corners = [t[0], t[1], t[2]].map(|i| &wood.vertices[i as usize]);
            let mask = masks.get(corners[0].material as usize).copied().flatten();
            self.triangle(corners.map(|v| (v.position, v.uv)), mask, WOOD);
        }
        let foliage = &tree.foliage;
        let masks: Vec<Option<Mask<'_>>> = foliage.materials.iter().map(Mask::of).collect();
        for leaf in &foliage.leaves {
            let shape = &foliage.shapes[leaf.shape as usize];
            let mask = masks.get(leaf.material as usize).copied().flatten();
            for t in shape.indices.chunks_exact(3) {
                let corners = [t[0], t[1], t[2]].map(|i| {
                    let position = shape.positions[i as usize];
                    let placed = leaf.center + leaf.orientation * position * leaf.scale;
                    (placed, shape.uvs[i as usize])
                });
                self.triangle(corners, mask, LEAVES);
            }
        }
    }

    fn triangle(&mut self, corners: [(Vec3, Vec2); 3], mask: Option<Mask<'_>>, color: Vec3) {
        let [a, b, c] = corners.map(|(position, _)| position);
        let normal = (self.view.turn * (b - a).cross(c - a)).normalize_or(Vec3::Z);
        // Both sides are lit alike.
        let light = 0.45 + 0.55 * normal.dot(Vec3::new(0.36, 0.48, 0.8)).abs();
        let [p, q, r] = corners.map(|(position, _)| self.place(position));
        let twice = (q - p).truncate().perp_dot((r - p).truncate());
        if twice == 0.0 || !twice.is_finite() {
            return;
        }
        let (low, high) = (p.min(q).min(r), p.max(q).max(r));
        let clamp = |x: f32| x.clamp(0.0, Self::SIDE as f32) as usize;
        for y in clamp(low.y.floor())..clamp(high.y.ceil()) {
            for x in clamp(low.x.floor())..clamp(high.x.ceil()) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let share = |from: Vec3, to: Vec3| {
                    (to - from).truncate().perp_dot(at - from.truncate()) / twice
                };
                let (u, v, w) = (share(q, r), share(r, p), share(p, q));
                let i = y * Self::SIDE + x;
                let depth = p.z * u + q.z * v + r.z * w;
                if u < 0.0 || v < 0.0 || w < 0.0 || depth <= self.depths[i] {
                    continue;
                }
                let uv = corners[0].1 * u + corners[1].1 * v + corners[2].1 * w;
                if mask.is_none_or(|mask| mask.covers(uv)) {
                    (self.colors[i], self.depths[i]) = (color * light, depth);
                }
            }
        }
    }

    fn pixel(&self, x: usize, y: usize) -> Vec3 {
        let samples = (0..SAMPLES * SAMPLES).map(|i| {
            let (x, y) = (x * SAMPLES + i % SAMPLES, y * SAMPLES + i / SAMPLES);
            self.colors[y * Self::SIDE + x]
        });
        samples.sum::<Vec3>() / (SAMPLES * SAMPLES) as f32
    }
}
