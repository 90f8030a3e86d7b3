//! The terrain as it is drawn, out to the horizon: squares of cells, the wider the farther.

use crate::base::layouts;
use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec2, Vec3, Vec4};
use wgpu::util::DeviceExt;
use windfall_core::forest::{Frustum, Terrain};

/// How far the ground goes on beyond the terrain's edge, metres.
const HORIZON: f32 = 6000.0;
/// How far from the terrain's middle the land of the backdrop begins: its half, this much more, and
/// not nearer than [`NEAREST_BACKDROP`], metres.
const MEADOW: f32 = 40.0;
const NEAREST_BACKDROP: f32 = 140.0;

/// Cells along a side of a square of ground that is drawn at once.
pub const PATCH: u32 = 4;
/// Where cells would be narrower than this, pixels, ones twice as wide are drawn: near the horizon they are flat, and a
/// triangle that is thinner than a pixel costs four of them.
const CELL_PIXELS: f32 = 80.0;
/// But only where the terrain is at most this far from them, pixels.
const ERROR_PIXELS: f32 = 0.5;
/// From which share of the distance at which wider cells take over narrower ones turn into them.
const MORPH: f32 = 0.75;

/// A square of the ground, `PATCH` cells a side, or what continues it beyond the terrain's rim: `Square` in `ground.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Square {
    /// First corner in cells of the terrain.
    pub first: [f32; 2],
    /// Cells of the terrain along a side of one of its own.
    pub step: f32,
    /// Where cells twice as wide take over, metres from the eye on the level.
    pub end: f32,
    /// Beyond which rim it lies: -1, 0 or 1 along x and z.
    pub beyond: [i32; 2],
}

/// Numbers that the shader knows too.
pub fn constants() -> String {
    format!(
        "const PATCH: u32 = {PATCH}u;\nconst MORPH: f32 = {MORPH:?};\nconst HORIZON: f32 = {HORIZON:?};\n"
    )
}

/// The terrain as it is drawn.
pub struct GroundMesh {
    /// Triangles of a square.
    pub indices: wgpu::Buffer,
    pub index_count: u32,
    /// The heights.
    pub heights: wgpu::BindGroup,
    /// `Frame::backdrop`.
    pub backdrop: Vec4,
    /// Cells along a side, and the width of one, metres.
    cells: u32,
    cell: f32,
    /// Lowest and highest height.
    range: (f32, f32),
    /// How far the terrain is from cells of 1, 2, 4... of its own a side, metres.
    errors: Vec<f32>,
}

impl GroundMesh {
    /// The same two triangles a cell as [`Terrain`] near the eye.
    pub fn new(device: &wgpu::Device, heights: &wgpu::BindGroupLayout, terrain: &Terrain) -> Self {
        let side = PATCH as u16 + 1;
        let mut indices = Vec::new();
        for j in 0..PATCH as u16 {
            for i in 0..PATCH as u16 {
                let a = j * side + i;
                let (b, c, d) = (a + 1, a + side, a + side + 1);
                indices.extend_from_slice(&[a, c, b, b, c, d]);
            }
        }
        let init = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let table: Vec<f32> = [terrain.side() as f32, terrain.cell()]
            .into_iter()
            .chain(terrain.heights().iter().copied())
            .collect();
        let table =
            init("terrain heights", bytemuck::cast_slice(&table), wgpu::BufferUsages::STORAGE);
        let cells = terrain.side() - 1;
        Self {
            heights: layouts::group(
                device,
                "terrain heights",
                heights,
                &[table.as_entire_binding()],
            ),
            backdrop: backdrop(terrain),
            indices: init(
                "ground indices",
                bytemuck::cast_slice(&indices),
                wgpu::BufferUsages::INDEX,
            ),
            index_count: indices.len() as u32,
            cells,
            cell: terrain.cell(),
            range: terrain.range(),
            errors: (0..=cells.div_ceil(PATCH).next_power_of_two().ilog2())
                .map(|level| error(terrain, 1 << level))
                .collect(),
        }
    }

    /// The squares that a view draws: the farther, the wider their cells. `pixels` is how many a metre covers at a
    /// distance of one.
    pub fn squares(&self, eye: Vec3, pixels: f32, frustum: &Frustum) -> Vec<Square> {
        let ends = self.ends(eye.y, pixels);
        let mut squares = Vec::new();
        let top = self.errors.len() - 1;
        let mut nodes = vec![(UVec2::ZERO, top)];
        while let Some((first, level)) = nodes.pop() {
            let wide = PATCH << level;
            let last = (first + wide).min(UVec2::splat(self.cells));
            if first.cmpge(last).any() {
                continue;
            }
            let [low, high] = [first, last].map(|at| self.place(at.as_vec2()));
            let eye = Vec2::new(eye.x, eye.z);
            // Cells of this level begin where those half as wide end.
            if level > 0 && eye.distance(eye.clamp(low, high)) < ends[level - 1] {
                let half = wide / 2;
                nodes.extend(
                    [(0, 0), (1, 0), (0, 1), (1, 1)]
                        .map(|(x, z)| (first + UVec2::new(x, z) * half, level - 1)),
                );
                continue;
            }
            let square = |beyond| Square {
                first: first.as_vec2().to_array(),
                step: (1 << level) as f32,
                end: ends[level],
                beyond,
            };
            let middle = (low + high) * 0.5;
            let (lowest, highest) = self.range;
            let center = Vec3::new(middle.x, (lowest + highest) * 0.5, middle.y);
            let radius = Vec3::new(high.x - middle.x, (highest - lowest) * 0.5, high.y - middle.y);
            if frustum.sees_sphere(center, radius.length()) {
                squares.push(square([0, 0]));
            }
            let rim =
                |first: u32, last: u32| [(first == 0, -1), (true, 0), (last == self.cells, 1)];
            for (_, x) in rim(first.x, last.x).into_iter().filter(|(is, _)| *is) {
                for (_, z) in rim(first.y, last.y).into_iter().filter(|(is, _)| *is) {
                    if (x, z) != (0, 0) {
                        squares.push(square([x, z]));
                    }
                }
            }
        }
        squares
    }

    /// A place of the grid in metres.
    fn place(&self, at: Vec2) -> Vec2 {
        (at - 0.5 * self.cells as f32) * self.cell
    }

    /// Up to which distance from the eye on the level cells of each level are drawn, metres.
    fn ends(&self, eye: f32, pixels: f32) -> Vec<f32> {
        let (lowest, highest) = self.range;
        let above = (eye - highest).max(lowest - eye).max(0.0);
        let mut ends: Vec<f32> = Vec::with_capacity(self.errors.len());
        for level in 0..self.errors.len() {
            let step = self.cell * (1 << level) as f32;
            let error = self.errors.get(level + 1).copied().unwrap_or(f32::INFINITY);
            let far = (2.0 * step / CELL_PIXELS).max(error / ERROR_PIXELS) * pixels;
            let mut end = (far * far - above * above).max(0.0).sqrt();
            if let Some(before) = ends.last() {
                // A square of the level before, whose parent begins before that level's end, ends before this one's
                // cells begin to turn.
                let parent = std::f32::consts::SQRT_2 * PATCH as f32 * step;
                end = end.max((before + parent) / MORPH);
            }
            ends.push(end);
        }
        // The widest are never replaced.
        if let Some(last) = ends.last_mut() {
            *last = f32::MAX;
        }
        ends
    }
}

/// How far a terrain is from its samples at every so many, metres.
fn error(terrain: &Terrain, step: u32) -> f32 {
    let last = terrain.side() - 1;
    let at = |x: u32, z: u32| terrain.heights()[(z.min(last) * (last + 1) + x.min(last)) as usize];
    let mut error = 0.0_f32;
    for z in 0..=last {
        for x in 0..=last {
            let (west, north) = (x / step * step, z / step * step);
            let (east, south) = ((west + step).min(last), (north + step).min(last));
            let share = |v: u32, low: u32, high: u32| {
                if high > low { (v - low) as f32 / (high - low) as f32 } else { 0.0 }
            };
            let (u, v) = (share(x, west, east), share(z, north, south));
            let [a, b, c, d] =
                [(west, north), (east, north), (west, south), (east, south)].map(|(x, z)| at(x, z));
            let flat = if u + v <= 1.0 {
                a + (b - a) * u + (c - a) * v
            } else {
                d + (c - d) * (1.0 - u) + (b - d) * (1.0 - v)
            };
            error = error.max((at(x, z) - flat).abs());
        }
    }
    error
}

/// The plane nearest to the terrain's rim, and the distance at which the backdrop stands on it.
fn backdrop(terrain: &Terrain) -> Vec4 {
    const PLACES: u32 = 64;
    let radius = (terrain.extent() * 0.5 + MEADOW).max(NEAREST_BACKDROP);
    let mut plane = Vec3::ZERO;
    for i in 0..PLACES {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / PLACES as f32).sin_cos();
        let height = terrain.height(radius * cos, radius * sin);
        // Least squares over a circle: the mean, and twice the first waves.
        plane += Vec3::new(1.0, 2.0 * cos / radius, 2.0 * sin / radius) * height;
    }
    (plane / PLACES as f32).extend(radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;

    /// Ground with hills of so many metres.
    fn hilly(relief: f32) -> (Terrain, GroundMesh) {
        let terrain = Terrain::rolling(200.0, relief, 3);
        let (device, _) = windfall_testing::device();
        let layouts = layouts::Layouts::new(&device);
        let mesh = GroundMesh::new(&device, &layouts.heights, &terrain);
        (terrain, mesh)
    }

    /// A view of everything.
    fn all() -> Frustum {
        Frustum::new(Mat4::from_scale(Vec3::splat(1e-6)))
    }

    #[test]
    fn squares_cover_each_cell_once_the_wider_the_farther() {
        let (terrain, mesh) = hilly(8.0);
        let cells = terrain.side() - 1;
        for eye in [Vec3::new(30.0, 2.0, -60.0), Vec3::new(0.0, 80.0, 0.0), Vec3::splat(500.0)] {
            let mut covered = vec![0.0; (cells * cells) as usize];
            for square in mesh.squares(eye, 300.0, &all()) {
                if square.beyond != [0, 0] {
                    continue;
                }
                let first = square.first.map(|v| v as u32);
                let wide = PATCH * square.step as u32;
                for z in first[1]..(first[1] + wide).min(cells) {
                    for x in first[0]..(first[0] + wide).min(cells) {
                        let step = &mut covered[(z * cells + x) as usize];
                        assert_eq!(*step, 0.0, "cell {x}, {z} twice");
                        *step = square.step;
                    }
                }
            }
            let steps: Vec<u32> = covered.iter().map(|&step| step as u32).collect();
            assert!(steps.iter().all(|&step| step > 0), "a gap from {eye}");
            for z in 0..cells as usize {
                for x in 1..cells as usize {
                    let at = z * cells as usize + x;
                    let pair = (steps[at - 1].min(steps[at]), steps[at - 1].max(steps[at]));
                    assert!(pair.1 <= 2 * pair.0, "{pair:?} meet from {eye}");
                }
            }
            let widest = steps.iter().max();
            assert!(widest > Some(&1), "{eye}: {widest:?}");
        }
        // Near the eye the terrain itself.
        let near = mesh.squares(Vec3::Y, 300.0, &all());
        let own = near.iter().find(|s| s.beyond == [0, 0] && s.first == [48.0, 48.0]);
        assert_eq!(own.map(|s| s.step), Some(1.0));
        // A rim of so many cells, and four corners.
        let corners = near.iter().filter(|s| s.beyond.iter().all(|&side| side != 0)).count();
        assert_eq!(corners, 4);
    }

    /// Where squares of different cells meet, the narrower have become the wider, and those have not begun to become
    /// others: what the vertex shader needs so that no gap opens.
    #[test]
    fn where_squares_meet_cells_have_turned() {
        for (relief, pixels) in [(0.1, 300.0), (0.1, 900.0), (8.0, 200.0)] {
            let (_, mesh) = hilly(relief);
            let eye = Vec3::new(30.0, 2.0, -60.0);
            let squares = mesh.squares(eye, pixels, &all());
            let inner: Vec<&Square> = squares.iter().filter(|s| s.beyond == [0, 0]).collect();
            let sides = |s: &Square| {
                let low = Vec2::from(s.first);
                (low, (low + PATCH as f32 * s.step).min(Vec2::splat(mesh.cells as f32)))
            };
            let mut met = 0;
            for narrow in &inner {
                for wide in inner.iter().filter(|wide| wide.step > narrow.step) {
                    let ((a, b), (c, d)) = (sides(narrow), sides(wide));
                    // Corners of the narrower on the rim of the wider.
                    for corner in [a, b, Vec2::new(a.x, b.y), Vec2::new(b.x, a.y)] {
                        if corner.cmpge(c).all() && corner.cmple(d).all() {
                            let away = mesh.place(corner).distance(Vec2::new(eye.x, eye.z));
                            assert!(away >= narrow.end * 0.9999, "{narrow:?} {wide:?} {away}");
                            assert!(away <= MORPH * wide.end, "{narrow:?} {wide:?} {away}");
                            met += 1;
                        }
                    }
                }
            }
            assert!(met > 10, "{relief}: {met}");
        }
    }

    #[test]
    fn the_backdrop_stands_on_the_rim_of_the_terrain() {
        assert_eq!(backdrop(&Terrain::flat()), Vec4::new(0.0, 0.0, 0.0, NEAREST_BACKDROP));
        // A slope of 0.1 over 400 m, level beyond: between 0.08 and 0.1 at the rim.
        let plane = backdrop(&Terrain::slope(Vec2::new(0.0, -0.1), 400.0));
        assert!(plane.x.abs() < 1e-3 && plane.y.abs() < 1e-4, "{plane}");
        assert!((-0.1..-0.08).contains(&plane.z), "{plane}");
        assert_eq!(plane.w, 240.0);
    }
}
