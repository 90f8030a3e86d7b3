//! The leaves of a tree: one list in prune order, in which a leaf keeps its identity from twig to
//! litter.

mod mask;
mod mesh;
mod pieces;
mod shapes;

pub use mask::Holes;
pub(crate) use mask::Mask;
pub(crate) use mesh::Mesh;
pub(crate) use pieces::pieces;
pub(crate) use shapes::Shaper;

use crate::rng::{Rng, hash, unit};
use crate::simplify::{Shading, Visibility, openness};
use crate::tree::Material;
use glam::{Quat, Vec2, Vec3};

/// All leaves of a tree model.
///
/// **Prune order** is the order of [`Foliage::leaves`]: a simplified tree draws a prefix of it
/// (Fichtner, section 3.2). **Shed order** is an index list over the same leaves.
#[derive(Debug, Clone, Default)]
pub struct Foliage {
    /// The leaves, in prune order.
    pub leaves: Vec<Leaf>,
    /// What the leaves' `shape` refers to.
    pub shapes: Vec<LeafShape>,
    /// What the leaves' `material` refers to.
    pub materials: Vec<Material>,
    /// Colours through autumn; `None` keeps the material's own colour.
    pub palette: Option<Palette>,
    /// Leaf indices in the order in which they fall: `shed_order[leaf.shed_rank] = leaf`.
    pub shed_order: Vec<u32>,
    /// Mean of the leaves' centres, metres.
    pub crown_center: Vec3,
    /// What the crown shows of its leaves, in the prune order that they were put in.
    pub visibility: Visibility,
    /// What shading draws together towards in simplified trees.
    pub shading: Shading,
}

/// One leaf element: a leaf, or a card with a twig of leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaf {
    /// Centre of the element in the tree, metres.
    pub center: Vec3,
    /// Rotation from the leaf's own frame into the tree's ([`LeafShape`] says what that frame is).
    pub orientation: Quat,
    /// Size: factor on the shape's coordinates, above 0.
    pub scale: f32,
    /// Index into [`Foliage::shapes`].
    pub shape: u32,
    /// Index into [`Foliage::materials`].
    pub material: u32,
    /// Unit mean of the leaf's own normal and the direction from the crown's centre (Fichtner,
    /// section 4.1).
    pub bent_normal: Vec3,
    /// Ambient light that reaches the leaf through the crown, `0..=1` (Vázquez & Balsa, 7.1).
    pub ambient: f32,
    /// Place of the leaf in [`Foliage::shed_order`].
    pub shed_rank: u32,
}

/// Geometry that leaves share.
///
/// Leaf frame: +Y is the upper side's normal, +Z runs from petiole to tip (the long axis), X is the
/// width; the origin is the centre of the shape's area. Metres at scale 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LeafShape {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals, as many as positions.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions. For built-in leaves: the outline in the unit
    /// square, `v` from 0 at the petiole to 1 at the tip, the midrib at `u` = ½.
    pub uvs: Vec<Vec2>,
    /// Triangles, three indices each, counter-clockwise seen from the upper side.
    pub indices: Vec<u32>,
}

/// Colours of a species through autumn.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    /// Linear colours at equal steps of the season's phase, from 0 (late summer) to 1 (ready to
    /// fall); at least one.
    pub stops: Vec<Vec3>,
    /// Spread of the phase over the leaves of one tree, `0..=1`.
    pub spread: f32,
}

impl Palette {
    /// Linear colour at a phase, clamped to `0..=1`.
    pub fn color(&self, phase: f32) -> Vec3 {
        let last = self.stops.len().saturating_sub(1);
        let x = phase.clamp(0.0, 1.0) * last as f32;
        let i = (x as usize).min(last.saturating_sub(1));
        let next = (i + 1).min(last);
        self.stops[i].lerp(self.stops[next], x - i as f32)
    }
}

impl LeafShape {
    /// Radius of the smallest sphere about the origin that holds the shape, metres at scale 1.
    pub fn radius(&self) -> f32 {
        self.positions.iter().map(|p| p.length_squared()).fold(0.0, f32::max).sqrt()
    }

    /// One-sided area, square metres at scale 1.
    pub fn area(&self) -> f32 {
        self.sum(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|i| self.positions[i]);
            (b - a).cross(c - a).length() * 0.5
        })
    }

    /// Area in texture coordinates: 1 of the whole picture.
    fn area_on_picture(&self) -> f32 {
        self.sum(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|i| self.uvs[i]);
            (b - a).perp_dot(c - a).abs() * 0.5
        })
    }

    /// Over its triangles, by their corners.
    fn sum(&self, of: impl Fn([usize; 3]) -> f32) -> f32 {
        self.indices.chunks_exact(3).map(|t| of([t[0], t[1], t[2]].map(|i| i as usize))).sum()
    }
}

impl Foliage {
    /// Puts leaves together into a foliage: finds the crown's centre and the share of a leaf in what
    /// is seen of it, bends the normals, and makes the prune order (random, Fichtner 3.2) and the
    /// shed order, and finds how open to the sky each leaf is. `ambient` is overwritten; `bent_normal`
    /// is read as the leaf's own normal; `shed_rank` is overwritten.
    pub fn assemble(
        mut leaves: Vec<Leaf>,
        shapes: Vec<LeafShape>,
        materials: Vec<Material>,
        palette: Option<Palette>,
        seed: u32,
    ) -> Self {
        let count = leaves.len().max(1) as f32;
        let crown_center: Vec3 = leaves.iter().map(|l| l.center / count).sum();
        for leaf in &mut leaves {
            let outward = (leaf.center - crown_center).normalize_or_zero();
            // A leaf is lit on both sides: bend the side that looks outward.
            let own =
                leaf.bent_normal * if leaf.bent_normal.dot(outward) < 0.0 { -1.0 } else { 1.0 };
            leaf.bent_normal = (own + outward).normalize_or(Vec3::Y);
        }
        Rng::new(seed).stream(1).shuffle(&mut leaves);
        let mut shed_order: Vec<u32> = (0..leaves.len() as u32).collect();
        let low = leaves.iter().map(|l| l.center.y).fold(f32::INFINITY, f32::min);
        let high = leaves.iter().map(|l| l.center.y).fold(f32::NEG_INFINITY, f32::max);
        let span = (high - low).max(f32::MIN_POSITIVE);
        // Chance, with the wind-swept top a little earlier than the sheltered foot of the crown.
        let key = |i: u32| {
            unit(hash(seed ^ 0x51ed, i)) - 0.35 * (leaves[i as usize].center.y - low) / span
        };
        shed_order.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
        for (rank, &leaf) in shed_order.iter().enumerate() {
            leaves[leaf as usize].shed_rank = rank as u32;
        }
        let mut foliage = Self {
            leaves,
            shapes,
            materials,
            palette,
            shed_order,
            crown_center,
            visibility: Visibility::default(),
            shading: Shading::default(),
        };
        let open = openness(&foliage);
        for (leaf, open) in foliage.leaves.iter_mut().zip(open) {
            leaf.ambient = open;
        }
        foliage.look();
        foliage.shading = Shading::of(&foliage);
        foliage
    }

    /// Mean length of a leaf, metres: twice the radius of its shape; 0 without leaves.
    pub fn leaf_length(&self) -> f32 {
        self.mean(|leaf| 2.0 * leaf.scale * self.shapes[leaf.shape as usize].radius())
    }

    /// Side of a square as large as what a leaf shows in the mean, holes and all, metres: half of its area, as of
    /// leaves that lean in every direction alike.
    pub fn leaf_side(&self) -> f32 {
        let areas: Vec<f32> = self.shapes.iter().map(LeafShape::area).collect();
        self.mean(|leaf| 0.5 * leaf.scale * leaf.scale * areas[leaf.shape as usize]).sqrt()
    }

    /// The holes in its leaves, in the mean over their areas.
    pub fn holes(&self) -> Holes {
        let areas: Vec<f32> = self.shapes.iter().map(LeafShape::area).collect();
        let on_pictures: Vec<f32> = self.shapes.iter().map(LeafShape::area_on_picture).collect();
        let of_pictures: Vec<Holes> = self.materials.iter().map(Material::holes).collect();
        let (mut solid, mut piece, mut all) = (0.0, 0.0, 0.0);
        for leaf in &self.leaves {
            let (shape, area) =
                (leaf.shape as usize, leaf.scale * leaf.scale * areas[leaf.shape as usize]);
            let holes = of_pictures.get(leaf.material as usize).copied().unwrap_or(Holes::NONE);
            // Of the part of the picture that the leaf has.
            let of_leaf = |share: f32| {
                if holes == Holes::NONE { 1.0 } else { (share / on_pictures[shape]).min(1.0) }
            };
            solid += area * of_leaf(holes.solid);
            piece += area * of_leaf(holes.piece * holes.piece);
            all += area;
        }
        if all > 0.0 {
            Holes { solid: solid / all, piece: (piece / all).sqrt() }
        } else {
            Holes::NONE
        }
    }

    fn mean(&self, of: impl Fn(&Leaf) -> f32) -> f32 {
        self.leaves.iter().map(of).sum::<f32>() / self.leaves.len().max(1) as f32
    }

    /// Looks at the crown, for `visibility`.
    pub(crate) fn look(&mut self) {
        self.visibility = Visibility::of(self);
    }

    /// Half of the box about [`Self::crown_center`] that holds all leaves' centres, metres; above 0.
    pub fn crown_extent(&self) -> Vec3 {
        let extents = self.leaves.iter().map(|l| (l.center - self.crown_center).abs());
        extents.fold(Vec3::splat(1e-3), Vec3::max)
    }

    /// Triangles of all leaves.
    pub fn triangle_count(&self) -> usize {
        self.leaves.iter().map(|l| self.shapes[l.shape as usize].indices.len() / 3).sum()
    }

    /// Vertices of all leaves.
    pub fn vertex_count(&self) -> usize {
        self.leaves.iter().map(|l| self.shapes[l.shape as usize].positions.len()).sum()
    }

    pub(crate) fn scale_positions(&mut self, factor: f32) {
        for leaf in &mut self.leaves {
            leaf.center *= factor;
            leaf.scale *= factor;
        }
        self.crown_center *= factor;
    }

    pub(crate) fn translate(&mut self, by: Vec3) {
        for leaf in &mut self.leaves {
            leaf.center += by;
        }
        self.crown_center += by;
    }
}
