//! The leaves of a tree: one list in prune order, in which a leaf keeps its identity from twig to
//! litter.

pub mod season;
mod shading;
mod visibility;

pub use crate::material::Holes;
pub use season::LeafSeason;
pub use shading::Shading;
pub use visibility::{Visibility, area_scale, share_for};

use crate::material::Material;
use crate::rng::{Rng, hash, unit};
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
    /// Visibility of the leaves, measured in their prune order. Default if the tree has not been prepared.
    pub visibility: Visibility,
    /// Mean shading, towards which simplified trees converge. Default if the tree has not been prepared.
    pub shading: Shading,
    /// For each shape one of two triangles for far trees, or `None` where the shape itself is drawn. Empty if the tree
    /// has not been prepared.
    pub simple_shapes: Vec<Option<LeafShape>>,
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
    /// Ambient light that reaches the leaf through the crown, `0..=1` (Vázquez & Balsa, 7.1); 1 if the tree has
    /// not been prepared.
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

    /// Farthest that the shape reaches from its leaf's plane, metres at scale 1.
    pub fn thickness(&self) -> f32 {
        self.positions.iter().map(|p| p.y.abs()).fold(0.0, f32::max)
    }

    /// One-sided area, square metres at scale 1.
    pub fn area(&self) -> f32 {
        self.sum(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|i| self.positions[i]);
            (b - a).cross(c - a).length() * 0.5
        })
    }

    /// Area in texture coordinates: 1 for the whole texture.
    fn area_on_texture(&self) -> f32 {
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
    /// Assembles a foliage: finds the crown's centre, bends the normals, and makes the prune order (random,
    /// Fichtner 3.2) and the shed order. `bent_normal` is read as the leaf's own normal; `shed_rank` is
    /// overwritten.
    ///
    /// Nothing is measured: `windfall_tree::prepare` does that once the tree is whole.
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
        Self { leaves, shapes, materials, palette, shed_order, crown_center, ..Self::default() }
    }

    /// Mean length of a leaf, metres: twice the radius of its shape; 0 without leaves.
    pub fn leaf_length(&self) -> f32 {
        self.mean(|leaf| 2.0 * leaf.scale * self.shapes[leaf.shape as usize].radius())
    }

    /// Lengths of the shortest and of the longest leaf, metres; 0 without leaves.
    pub fn leaf_lengths(&self) -> [f32; 2] {
        let radii: Vec<f32> = self.shapes.iter().map(LeafShape::radius).collect();
        let lengths = self.leaves.iter().map(|leaf| 2.0 * leaf.scale * radii[leaf.shape as usize]);
        let [low, high] = lengths.fold([f32::INFINITY, 0.0], |[low, high]: [f32; 2], length| {
            [low.min(length), high.max(length)]
        });
        [low.min(high), high]
    }

    /// Side of a square with a leaf's mean projected area, holes included, metres: half of the leaf's area, as for
    /// normals uniform over the sphere.
    pub fn leaf_side(&self) -> f32 {
        let areas: Vec<f32> = self.shapes.iter().map(LeafShape::area).collect();
        self.mean(|leaf| 0.5 * leaf.scale * leaf.scale * areas[leaf.shape as usize]).sqrt()
    }

    /// Holes in the leaves, averaged over their areas.
    pub fn holes(&self) -> Holes {
        let areas: Vec<f32> = self.shapes.iter().map(LeafShape::area).collect();
        let on_textures: Vec<f32> = self.shapes.iter().map(LeafShape::area_on_texture).collect();
        let of_textures: Vec<Holes> = self.materials.iter().map(Material::holes).collect();
        let (mut solid, mut piece, mut all) = (0.0, 0.0, 0.0);
        for leaf in &self.leaves {
            let (shape, area) =
                (leaf.shape as usize, leaf.scale * leaf.scale * areas[leaf.shape as usize]);
            let holes = of_textures.get(leaf.material as usize).copied().unwrap_or(Holes::NONE);
            // Relative to the part of the texture that the leaf has.
            let of_leaf = |share: f32| {
                if holes == Holes::NONE { 1.0 } else { (share / on_textures[shape]).min(1.0) }
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

    /// Keeps the first `count` leaves in prune order; they keep their shed order.
    pub fn truncate(&mut self, count: usize) {
        self.leaves.truncate(count);
        self.shed_order.retain(|&leaf| (leaf as usize) < count);
        for (rank, &leaf) in self.shed_order.iter().enumerate() {
            self.leaves[leaf as usize].shed_rank = rank as u32;
        }
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

    /// Scales the crown about the origin.
    pub fn scale(&mut self, factor: f32) {
        for leaf in &mut self.leaves {
            leaf.center *= factor;
            leaf.scale *= factor;
        }
        self.crown_center *= factor;
    }

    /// Moves the crown.
    pub fn translate(&mut self, by: Vec3) {
        for leaf in &mut self.leaves {
            leaf.center += by;
        }
        self.crown_center += by;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Image, Surface};

    /// Leaves at these places that share a square of one metre, upright, facing +Z.
    fn squares(centers: &[Vec3]) -> Foliage {
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        let shape = LeafShape {
            positions: corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: corners.map(|(x, z)| Vec2::new(x + 0.5, z + 0.5)).to_vec(),
            indices: vec![0, 2, 1, 0, 3, 2],
        };
        let leaf = |&center: &Vec3| Leaf {
            center,
            orientation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
            scale: 1.0,
            shape: 0,
            material: 0,
            bent_normal: Vec3::Z,
            ambient: 1.0,
            shed_rank: 0,
        };
        let leaves = centers.iter().map(leaf).collect();
        Foliage::assemble(leaves, vec![shape], Vec::new(), None, 3)
    }

    #[test]
    fn leaves_show_half_of_their_area_in_the_mean() {
        let mut foliage = squares(&[Vec3::ZERO, Vec3::X]);
        foliage.leaves[1].scale = 2.0;
        // Of 1 and 4 square metres; diagonals of 1.41 and 2.83 m.
        assert!((foliage.leaf_side() - 1.25f32.sqrt()).abs() < 1e-6);
        assert!((foliage.leaf_length() - 1.5 * 2f32.sqrt()).abs() < 1e-6);
        assert_eq!([Foliage::default().leaf_side(), Foliage::default().leaf_length()], [0.0; 2]);
        let [short, long] = foliage.leaf_lengths();
        assert!(short < foliage.leaf_length() && foliage.leaf_length() < long);
        assert_eq!(Foliage::default().leaf_lengths(), [0.0; 2]);
    }

    #[test]
    fn holes_are_those_of_the_part_of_the_texture_that_leaves_have() {
        let mut foliage = squares(&[Vec3::ZERO]);
        // The left quarter of the texture is there.
        let rgba = [255, 255, 255, 255].iter().chain(&[0; 12]).copied().collect();
        foliage.materials = vec![Material {
            name: String::new(),
            base_color: Vec3::ONE,
            roughness: 1.0,
            alpha_cutoff: Some(0.5),
            surface: Surface::Texture(Image { width: 4, height: 1, rgba }, false),
        }];
        assert_eq!(foliage.holes(), Holes { solid: 0.25, piece: 0.5 });
        foliage.shapes[0].uvs.iter_mut().for_each(|uv| uv.x *= 0.5);
        assert_eq!(foliage.holes(), Holes { solid: 0.5, piece: 0.5f32.sqrt() });
        foliage.materials[0].alpha_cutoff = None;
        assert_eq!(foliage.holes(), Holes::NONE);
    }

    #[test]
    fn a_prefix_sheds_in_the_order_of_the_whole() {
        let places: Vec<Vec3> =
            (0..500).map(|i| Vec3::new(0.0, (i % 23) as f32, i as f32)).collect();
        let whole = squares(&places);
        let mut few = whole.clone();
        few.truncate(60);
        assert_eq!(few.leaves.len(), 60);
        assert!(few.leaves.iter().zip(&whole.leaves).all(|(a, b)| a.center == b.center));
        let mut of_whole = whole.shed_order.clone();
        of_whole.retain(|&leaf| leaf < 60);
        assert_eq!(few.shed_order, of_whole);
        assert_ne!(few.shed_order, (0..60).collect::<Vec<u32>>());
        assert!(
            (0..60).all(|rank| few.leaves[few.shed_order[rank] as usize].shed_rank == rank as u32)
        );
        few.truncate(1000);
        assert_eq!(few.leaves.len(), 60);
    }

    #[test]
    fn the_top_of_a_crown_sheds_before_its_foot() {
        let places: Vec<Vec3> = (0..2000).map(|i| Vec3::Y * (i % 100) as f32).collect();
        let foliage = squares(&places);
        let mean = |leaves: &[u32]| {
            let height = |&leaf: &u32| foliage.leaves[leaf as usize].center.y;
            leaves.iter().map(height).sum::<f32>() / leaves.len() as f32
        };
        let [early, late] = [&foliage.shed_order[..1000], &foliage.shed_order[1000..]].map(mean);
        // The key is chance in 0..1 less 0.35 times the height over the span.
        assert!(early > late + 10.0, "{early} {late}");
    }
}
