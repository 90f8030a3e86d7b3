//! Fall paths as a texture, and some numbers for each leaf: small, and for any length of time (VB 3.4, 4.1).
//!
//! This is P.-P. Vázquez and M. Balsa's own idea ("Rendering Falling Leaves on Graphics Hardware", JVRB 5(2), 2008): one
//! recorded path serves many leaves, each with its own turn, scale, rate and starting point. Loops are unrolled, so that
//! a shader reads one row ([`RATE`] samples a second) and never jumps. Everything is in Windfall's axes and metres;
//! `shaders/windfall_paths.wgsl` is the decoder.
//!
//! The wind's way is exact at the landing and for a steady wind; on the way gusts are smoothed.

use super::{Engine, LARGEST, texture};
use crate::selection::Selection;
use crate::{ExportError, LeafState};
use glam::{Quat, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use windfall_core::path::{Fall, FallSettings, LeafFall, Variant, Variation};
use windfall_core::wind::Wind;

/// Samples of a path a second.
pub const RATE: f32 = 120.0;
/// Texels of a leaf, one under the other.
pub const TEXELS: usize = 6;
/// Leaves in a row.
const COLUMNS: usize = 4096;

/// Path, continuity point and first sample.
type Flight = (u32, u32, u32);

/// The path texture, and the texture of the leaves.
pub struct PathTextures<'a> {
    selection: &'a Selection<'a>,
    engine: Engine,
    flights: BTreeMap<Flight, usize>,
    samples: usize,
    columns: usize,
    blocks: usize,
    /// A leaf's path alone: no wind, no twig, no variation.
    bare: Fall<'a>,
}

impl<'a> PathTextures<'a> {
    /// Finds the paths that the selection's leaves fall by, and how much of them.
    ///
    /// # Errors
    ///
    /// No leaf is selected, or more than fit into a texture; falls of more than two minutes.
    pub fn new(selection: &'a Selection<'a>, engine: Engine) -> Result<Self, ExportError> {
        let leaves = selection.len();
        if leaves == 0 {
            return Err(ExportError::Nothing("a texture needs leaves".to_owned()));
        }
        let columns = leaves.min(COLUMNS);
        let blocks = leaves.div_ceil(columns);
        if blocks * TEXELS > LARGEST {
            let most = LARGEST / TEXELS * COLUMNS;
            return Err(ExportError::TooManyLeaves { leaves, most, format: "a texture" });
        }
        let (mut found, mut longest) = (BTreeMap::new(), 0.0f32);
        for i in 0..leaves {
            let (_, landing, variant) = selection.fall_facts(i);
            found.insert((variant.path, variant.joint, variant.start), 0);
            if landing.time.is_finite() {
                longest = longest.max(landing.time * variant.rate);
            }
        }
        let samples = (longest * RATE).ceil() as usize + 2;
        if samples > LARGEST || 2 * found.len() > LARGEST {
            return Err(ExportError::TooManyFrames(samples.max(found.len()) as u32));
        }
        found.values_mut().enumerate().for_each(|(row, at)| *at = row);
        let source = selection.source();
        let settings = FallSettings { soft_drop: 0.0, soft_time: 0.0, ..source.settings };
        let (terrain, variation) = (&source.forest.terrain, Variation::default());
        let bare = Fall::new(source.paths, terrain, Wind::calm(), variation, settings);
        Ok(Self { selection, engine, flights: found, samples, columns, blocks, bare })
    }

    /// Width and height of the path texture: two rows a path, displacement with the drop so far, and orientation.
    pub fn path_size(&self) -> (usize, usize) {
        (self.samples, 2 * self.flights.len())
    }

    /// Width and height of the texture of leaves: [`TEXELS`] rows a block of leaves.
    pub fn leaf_size(&self) -> (usize, usize) {
        (self.columns, self.blocks * TEXELS)
    }

    /// Writes the path texture as OpenEXR.
    ///
    /// # Errors
    ///
    /// The output cannot be written.
    pub fn write_paths(&self, out: &mut (impl Write + Seek)) -> Result<(), ExportError> {
        let mut texels = Vec::with_capacity(2 * self.samples * self.flights.len());
        for &(path, joint, start) in self.flights.keys() {
            let variant =
                Variant { path, joint, start, yaw: 0.0, scale: Vec2::ONE, rate: 1.0, word: 0 };
            let leaf = still();
            let mut drop = 0.0f32;
            let poses: Vec<_> = (0..self.samples)
                .map(|i| self.bare.airborne(&leaf, &variant, i as f32 / RATE))
                .collect();
            for pose in &poses {
                drop = drop.max(-pose.position.y);
                texels.push(pose.position.extend(drop));
            }
            let mut before = Quat::IDENTITY;
            for pose in &poses {
                let q = pose.orientation.normalize();
                before = if before.dot(q) < 0.0 { -q } else { q };
                texels.push(Vec4::from(before));
            }
        }
        let width = self.samples;
        texture::write_exr(
            "paths",
            self.path_size(),
            |x, y| texels[y * width + x],
            out,
            &mut |_| (),
        )
    }

    /// The texels of a leaf:
    ///
    /// | texel | red, green, blue | alpha |
    /// |---|---|---|
    /// | 0 | centre on the twig | seconds of the detachment, after the first frame |
    /// | 1 | centre on the ground | seconds of the fall; 10⁹ for a leaf that hangs in all frames |
    /// | 2 | what turns the path's first orientation into the twig's, a quaternion | |
    /// | 3 | what turns the orientation at the landing into the one on the ground, a quaternion | |
    /// | 4 | turn about Y, radians; scales along X and Z | playback rate |
    /// | 5 | way of the wind along X and Z; number of the path | height of the leaf over the ground |
    pub fn leaf_texels(&self, i: usize) -> [Vec4; TEXELS] {
        let (leaf, landing, variant) = self.selection.fall_facts(i);
        let moments = self.selection.moments();
        let first = moments.time(moments.first);
        let row = self.flights[&(variant.path, variant.joint, variant.start)];
        let begin = self.bare.airborne(&still(), &variant, 0.0).orientation;
        let from_twig = begin.conjugate() * leaf.twig_orientation;
        let mut blown = Vec3::ZERO;
        let mut time = 1e9;
        if landing.time.is_finite() {
            time = landing.time;
            let settings = self.selection.source().settings;
            let unrolled =
                self.bare.airborne(&still(), &variant, soft_time(landing.time, settings.soft_time));
            blown = landing.position - leaf.origin - unrolled.position;
        }
        let lift = self.selection.lift(i);
        [
            leaf.origin.extend((leaf.detach_time - first) as f32),
            landing.position.extend(time),
            Vec4::from(from_twig.normalize()),
            Vec4::from(landing.settle.normalize()),
            Vec4::new(variant.yaw, variant.scale.x, variant.scale.y, variant.rate),
            Vec4::new(blown.x, blown.z, row as f32, lift),
        ]
    }

    /// Writes the texture of leaves as OpenEXR.
    ///
    /// # Errors
    ///
    /// The output cannot be written.
    pub fn write_leaves(
        &self,
        out: &mut (impl Write + Seek),
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        let texel = |x: usize, y: usize| {
            let leaf = y / TEXELS * self.columns + x;
            if leaf < self.selection.len() {
                self.leaf_texels(leaf)[y % TEXELS]
            } else {
                Vec4::ZERO
            }
        };
        texture::write_exr("leaves", self.leaf_size(), texel, out, progress)
    }

    /// Writes the mesh of the leaves, as [`super::Vat::write_mesh`] does it; `TEXCOORD_1` is a leaf's first texel.
    ///
    /// # Errors
    ///
    /// Those of [`super::Vat::write_mesh`].
    pub fn write_mesh(
        &self,
        out: &mut dyn Write,
        progress: &mut dyn FnMut(f32),
    ) -> Result<(), ExportError> {
        super::mesh::write(self.selection, &|i| self.address(i), out, progress)
    }

    /// Share of the texture of leaves at which leaf `i` has its first texel, at its middle.
    pub fn address(&self, i: usize) -> Vec2 {
        let (width, height) = self.leaf_size();
        let (column, row) = (i % self.columns, i / self.columns * TEXELS);
        Vec2::new((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32)
    }

    /// What an engine has to know, as JSON.
    pub fn sidecar(&self, paths: &str, leaves: &str, mesh: &str) -> Vec<u8> {
        let moments = self.selection.moments();
        let settings = self.selection.source().settings;
        let axes = self.engine.axes().transpose();
        let first = moments.time(moments.first);
        let all = || (0..self.selection.len()).map(|i| self.selection.state(i, first));
        let ids: Vec<u64> = all().map(|s: LeafState| s.id.0).collect();
        let scales: Vec<f32> = all().map(|s| s.scale).collect();
        let document: Value = json!({
            "format": "windfall-paths",
            "version": 1,
            "engine": self.engine.name(),
            "axes": [axes.x_axis.to_array(), axes.y_axis.to_array(), axes.z_axis.to_array()],
            "unitsPerMetre": self.engine.units(),
            "firstFrame": moments.first,
            "frames": moments.count,
            "fps": moments.fps,
            "samplesPerSecond": RATE,
            "samples": self.samples,
            "paths": { "file": paths, "count": self.flights.len() },
            "leaves": {
                "file": leaves, "count": self.selection.len(), "columns": self.columns, "texels": TEXELS,
            },
            "softDrop": settings.soft_drop,
            "softTime": settings.soft_time,
            "settleTime": settings.settle_time,
            "windResponse": settings.wind_response,
            "mesh": mesh,
            "ids": ids,
            "scales": scales,
        });
        document.to_string().into_bytes()
    }
}

/// A leaf at the origin that follows its path alone.
fn still() -> LeafFall {
    LeafFall {
        origin: Vec3::ZERO,
        twig_orientation: Quat::IDENTITY,
        tree: Vec3::ZERO,
        seed: 0,
        group: 0,
        detach_time: 0.0,
    }
}

/// Time on a path that starts from rest (VB 3.5), before the leaf's own rate.
fn soft_time(elapsed: f32, soft: f32) -> f32 {
    if elapsed < soft { elapsed * elapsed / (2.0 * soft) } else { elapsed - 0.5 * soft.max(0.0) }
}
