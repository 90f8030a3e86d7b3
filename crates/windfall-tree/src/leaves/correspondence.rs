//! Which corners of one leaf are which of another, when exporters have numbered both in their own ways.
//!
//! Optimizers order triangles and vertices for caches, over leaves and all. Two leaves are the same if their
//! triangles can be walked in step: from a first triangle of one and each corner of the other, over shared edges.

use super::pieces::Piece;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// A piece, ready to be walked.
#[derive(Debug, Clone)]
pub(super) struct Walk {
    /// Position of each place.
    pub points: Vec<Vec3>,
    /// Mean of the points.
    pub middle: Vec3,
    /// Root mean square of their distances from it.
    pub spread: f32,
    /// Places of the corners of each triangle.
    triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the same corners.
    uvs: Vec<[Vec2; 3]>,
}

impl Walk {
    pub fn of(piece: &Piece) -> Self {
        let mesh = &piece.mesh;
        let count = piece.places.iter().max().map_or(0, |last| *last as usize + 1);
        let mut points = vec![Vec3::ZERO; count];
        for (&place, &position) in piece.places.iter().zip(&mesh.positions) {
            points[place as usize] = position;
        }
        let middle = points.iter().sum::<Vec3>() / count.max(1) as f32;
        let squares = points.iter().map(|p| p.distance_squared(middle)).sum::<f32>();
        let corners = || mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
        Self {
            middle,
            spread: (squares / count.max(1) as f32).sqrt(),
            triangles: corners().map(|t| t.map(|i| piece.places[i as usize])).collect(),
            uvs: corners().map(|t| t.map(|i| mesh.uvs[i as usize])).collect(),
            points,
        }
    }

    /// Distance of the farthest point from the middle.
    pub fn radius(&self) -> f32 {
        self.points.iter().map(|p| p.distance(self.middle)).fold(0.0, f32::max)
    }

    /// A number that is the same for congruent pieces: how far out the farthest point is, against the root mean
    /// square of all.
    pub fn invariant(&self) -> f32 {
        if self.spread > 0.0 { self.radius() / self.spread } else { 0.0 }
    }

    /// Numbers of triangles and of places: the same for equal pieces.
    pub fn size(&self) -> (usize, usize) {
        (self.triangles.len(), self.points.len())
    }

    /// Calls `accept` with the place in `other` of each place here, for each way to walk both in step whose
    /// texture coordinates agree within `uv_tolerance` and lengths within `tolerance`, a part of the spread.
    /// The first result that it gives is the answer.
    pub fn find<T>(
        &self,
        other: &Self,
        uv_tolerance: f32,
        tolerance: f32,
        mut accept: impl FnMut(&[u32]) -> Option<T>,
    ) -> Option<T> {
        if self.size() != other.size() || self.triangles.is_empty() {
            return None;
        }
        let same_uvs = |a: &[Vec2; 3], b: &[Vec2; 3]| {
            a.iter().zip(b).all(|(a, b)| a.abs_diff_eq(*b, uv_tolerance))
        };
        // Most are numbered alike, and those need not hang together.
        if self.triangles == other.triangles
            && self.uvs.iter().zip(&other.uvs).all(|(a, b)| same_uvs(a, b))
        {
            let same: Vec<u32> = (0..self.points.len() as u32).collect();
            if let Some(found) = accept(&same) {
                return Some(found);
            }
        }
        let (own, others) = (self.edges(), other.edges());
        let first = self.lengths(0, 0);
        for triangle in 0..other.triangles.len() {
            for turn in 0..3 {
                let lengths = other.lengths(triangle, turn);
                if first.iter().zip(lengths).any(|(a, b)| (a - b).abs() > tolerance)
                    || !same_uvs(&self.uvs[0], &turned(other.uvs[triangle], turn))
                {
                    continue;
                }
                let places = self.walk(&own, other, &others, (triangle, turn), &same_uvs);
                if let Some(found) = places.and_then(|places| accept(&places)) {
                    return Some(found);
                }
            }
        }
        None
    }

    /// Lengths of a triangle's edges and distances of its corners from the middle, as parts of the spread.
    fn lengths(&self, triangle: usize, turn: usize) -> [f32; 6] {
        let p = turned(self.triangles[triangle], turn).map(|place| self.points[place as usize]);
        let spread = self.spread.max(f32::MIN_POSITIVE);
        [
            p[0].distance(p[1]),
            p[1].distance(p[2]),
            p[2].distance(p[0]),
            p[0].distance(self.middle),
            p[1].distance(self.middle),
            p[2].distance(self.middle),
        ]
        .map(|length| length / spread)
    }

    /// The triangle of each directed edge, and the corner where the edge begins.
    fn edges(&self) -> HashMap<(u32, u32), (usize, usize)> {
        let corners = (0..self.triangles.len()).flat_map(|t| (0..3).map(move |corner| (t, corner)));
        corners
            .map(|(t, corner)| {
                let [a, b, _] = turned(self.triangles[t], corner);
                ((a, b), (t, corner))
            })
            .collect()
    }

    fn walk(
        &self,
        own: &HashMap<(u32, u32), (usize, usize)>,
        other: &Self,
        others: &HashMap<(u32, u32), (usize, usize)>,
        start: (usize, usize),
        same_uvs: &impl Fn(&[Vec2; 3], &[Vec2; 3]) -> bool,
    ) -> Option<Vec<u32>> {
        const NONE: u32 = u32::MAX;
        let mut places = vec![NONE; self.points.len()];
        let mut taken = vec![false; other.points.len()];
        let mut seen = vec![false; self.triangles.len()];
        let mut next = vec![(0, 0, start.0, start.1)];
        let mut walked = 0;
        while let Some((a, corner, b, other_corner)) = next.pop() {
            if std::mem::replace(&mut seen[a], true) {
                continue;
            }
            walked += 1;
            let mine = turned(self.triangles[a], corner);
            let theirs = turned(other.triangles[b], other_corner);
            if !same_uvs(&turned(self.uvs[a], corner), &turned(other.uvs[b], other_corner)) {
                return None;
            }
            for (&here, &there) in mine.iter().zip(&theirs) {
                let place = &mut places[here as usize];
                if *place == NONE && !taken[there as usize] {
                    (*place, taken[there as usize]) = (there, true);
                } else if *place != there {
                    return None;
                }
            }
            for i in 0..3 {
                let (from, to) = (mine[i], mine[(i + 1) % 3]);
                let Some(&(t, corner)) = own.get(&(to, from)) else { continue };
                if !seen[t] {
                    let edge = (theirs[(i + 1) % 3], theirs[i]);
                    let &(other_t, other_corner) = others.get(&edge)?;
                    next.push((t, corner, other_t, other_corner));
                }
            }
        }
        (walked == self.triangles.len() && !places.contains(&NONE)).then_some(places)
    }
}

/// The corners of a triangle, beginning with another one.
fn turned<T: Copy>(corners: [T; 3], by: usize) -> [T; 3] {
    [corners[by % 3], corners[(by + 1) % 3], corners[(by + 2) % 3]]
}
