//! Poisson-disc placement: trees at random, none closer than the spacing.

use super::{Forest, Instance, Terrain};
use crate::rng::Rng;
use glam::{Vec2, Vec3};

/// How to place a forest. Trees fill a disc about the origin, no two closer than `spacing`.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Trees to place, 0 to [`Placement::MOST`].
    pub trees: u32,
    /// Least distance between trunks, metres, above 0.
    pub spacing: f32,
    /// Where no tree may stand.
    pub keep_out: Vec<KeepOut>,
    /// Smallest and largest factor on a model's size, both above 0.
    pub scale: (f32, f32),
    /// Largest season offset of a tree, either way.
    pub season_spread: f32,
    /// Key of the whole placement.
    pub seed: u32,
}

/// A capsule on the ground in which no trunk may stand: a glade, a path, a camera's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeepOut {
    /// One end, `(x, z)` in metres.
    pub from: Vec2,
    /// The other end.
    pub to: Vec2,
    /// Distance from the line between them, metres.
    pub radius: f32,
}

impl KeepOut {
    fn holds(&self, at: Vec2) -> bool {
        let along = self.to - self.from;
        let s = (at - self.from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
        at.distance(self.from + along * s.clamp(0.0, 1.0)) < self.radius
    }
}

impl Default for Placement {
    /// A hundred trees, 6 m apart, up to a fifth smaller or larger than their models.
    fn default() -> Self {
        Self {
            trees: 100,
            spacing: 6.0,
            keep_out: Vec::new(),
            scale: (0.8, 1.2),
            season_spread: 0.1,
            seed: 1,
        }
    }
}

impl Placement {
    /// Most trees of one forest.
    pub const MOST: u32 = 100_000;

    /// Radius of the disc that the trees fill, metres, keep-outs not counted.
    ///
    /// Random placement by rejection fills at most 0.547 of a plane with discs (Rényi's parking
    /// problem in two dimensions); at two thirds of that it still converges quickly.
    pub fn radius(&self) -> f32 {
        let disc = 0.25 * self.spacing * self.spacing;
        (self.trees as f32 * disc / (0.547 * 0.66)).sqrt()
    }

    /// Places `trees` of `models` models, drawn by `weights` (one each, at least one above 0).
    ///
    /// The same arguments give the same forest. The disc grows where keep-outs leave too little
    /// room. One tree without keep-outs stands at the origin.
    ///
    /// # Panics
    ///
    /// If `trees` is above [`Placement::MOST`], `spacing` is not above 0, or no weight is above 0.
    pub fn place(&self, terrain: Terrain, weights: &[f32]) -> Forest {
        assert!(self.trees <= Self::MOST, "{} trees", self.trees);
        assert!(self.spacing > 0.0, "spacing {}", self.spacing);
        let total: f32 = weights.iter().sum();
        assert!(total > 0.0 || self.trees == 0, "no model has a weight");
        let mut rng = Rng::new(self.seed);
        let instances = self
            .points(&mut rng.stream(1))
            .into_iter()
            .map(|at| {
                let mut pick = rng.unit() * total;
                let model = weights.iter().position(|w| {
                    pick -= w;
                    pick < 0.0
                });
                Instance {
                    model: model.unwrap_or(weights.len() - 1) as u32,
                    position: Vec3::new(at.x, terrain.height(at.x, at.y), at.y),
                    yaw: rng.range(0.0, std::f32::consts::TAU),
                    scale: rng.range(self.scale.0, self.scale.1),
                    season_offset: rng.range(-self.season_spread, self.season_spread),
                    seed: rng.next_u32(),
                }
            })
            .collect();
        Forest { terrain, instances }
    }

    fn points(&self, rng: &mut Rng) -> Vec<Vec2> {
        let wanted = self.trees as usize;
        if wanted == 1 && !self.keep_out.iter().any(|k| k.holds(Vec2::ZERO)) {
            return vec![Vec2::ZERO];
        }
        let mut points: Vec<Vec2> = Vec::with_capacity(wanted);
        let mut radius = self.radius();
        // A grid of cells that hold at most one point each (diagonal = spacing), grown with the disc.
        while points.len() < wanted {
            let cell = self.spacing / std::f32::consts::SQRT_2;
            let side = (2.0 * radius / cell).ceil() as usize + 1;
            let index = |p: Vec2| {
                let c = ((p + radius) / cell).max(Vec2::ZERO);
                ((c.x as usize).min(side - 1), (c.y as usize).min(side - 1))
            };
            let mut grid = vec![u32::MAX; side * side];
            for (i, &p) in points.iter().enumerate() {
                let (x, y) = index(p);
                grid[y * side + x] = i as u32;
            }
            let tries = 30 * (wanted - points.len()) + 100;
            for _ in 0..tries {
                let r = radius * rng.unit().sqrt();
                let at = Vec2::from_angle(rng.unit() * std::f32::consts::TAU) * r;
                let (x, y) = index(at);
                let near = (y.saturating_sub(2)..(y + 3).min(side)).any(|j| {
                    (x.saturating_sub(2)..(x + 3).min(side)).any(|i| {
                        let other = grid[j * side + i];
                        other != u32::MAX && points[other as usize].distance(at) < self.spacing
                    })
                });
                if !near && !self.keep_out.iter().any(|k| k.holds(at)) {
                    grid[y * side + x] = points.len() as u32;
                    points.push(at);
                    if points.len() == wanted {
                        break;
                    }
                }
            }
            radius *= 1.1;
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placement(trees: u32) -> Placement {
        Placement {
            trees,
            spacing: 6.0,
            keep_out: vec![KeepOut {
                from: Vec2::new(-20.0, 0.0),
                to: Vec2::new(30.0, 0.0),
                radius: 4.0,
            }],
            scale: (0.8, 1.2),
            season_spread: 0.1,
            seed: 9,
        }
    }

    #[test]
    fn no_two_trees_are_closer_than_the_spacing_and_none_stands_on_the_path() {
        let forest = placement(500).place(Terrain::rolling(200.0, 4.0, 1), &[1.0, 3.0]);
        assert_eq!(forest.instances.len(), 500);
        let mut models = [0; 2];
        for (i, a) in forest.instances.iter().enumerate() {
            models[a.model as usize] += 1;
            assert!((0.8..1.2).contains(&a.scale) && a.season_offset.abs() <= 0.1);
            assert_eq!(a.position.y, forest.terrain.height(a.position.x, a.position.z));
            let on_path = (-20.0..30.0).contains(&a.position.x) && a.position.z.abs() < 4.0;
            assert!(!on_path, "{:?}", a.position);
            for b in &forest.instances[..i] {
                let (a, b) = (a.position, b.position);
                assert!(Vec2::new(a.x - b.x, a.z - b.z).length() >= 6.0);
            }
        }
        assert!(models[1] > 2 * models[0] && models[0] > 60, "{models:?}");
    }

    #[test]
    fn the_same_seed_gives_the_same_forest_and_another_seed_another() {
        let forest =
            |seed| Placement { seed, ..placement(50) }.place(Terrain::flat(), &[1.0]).instances;
        assert_eq!(forest(1), forest(1));
        assert_ne!(forest(1), forest(2));
    }

    #[test]
    fn none_one_and_a_hundred_thousand_trees() {
        let count = |trees| {
            let placement = Placement { keep_out: vec![], ..placement(trees) };
            placement.place(Terrain::flat(), &[1.0]).instances.len()
        };
        assert_eq!([count(0), count(1), count(100_000)], [0, 1, 100_000]);
        let one = Placement { keep_out: vec![], ..placement(1) }.place(Terrain::flat(), &[1.0]);
        assert_eq!(one.instances[0].position, Vec3::ZERO);
    }
}
