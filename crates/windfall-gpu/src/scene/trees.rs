//! The trees of a forest: their records, and the tables that lists of trees are made from.

use crate::base::constants::{BLOCK, OUTLINES};
use crate::base::shared::{Crown, TreeRecord};
use crate::scene::model::TreeModel;
use crate::scene::parts::PartDraw;
use bytemuck::Zeroable;
use glam::Vec3;
use std::ops::Range;

/// Models, places of trees, and draws.
pub struct TreeTables {
    /// Of each model; with their places and draws.
    pub crowns: Vec<Crown>,
    /// By model, each model's in whole blocks; a place may hold no tree.
    pub records: Vec<TreeRecord>,
    /// For each model its draws: ranges of all draws.
    pub draws: Vec<DrawRanges>,
    /// All draws.
    pub parts: Vec<PartDraw>,
}

/// A model's draws.
#[derive(Debug, Clone)]
pub struct DrawRanges {
    /// Of outlines, in prune order.
    pub outlines: Range<u32>,
    /// Of leaves in two triangles, in prune order.
    pub simple: Range<u32>,
    /// Of levels of wood.
    pub wood: Range<u32>,
}

/// A place that holds no tree.
pub fn no_tree() -> TreeRecord {
    TreeRecord { model: u32::MAX, ..TreeRecord::zeroed() }
}

impl TreeTables {
    /// Tables of models with so many places each, all empty.
    pub fn new(models: &[(TreeModel, u32)]) -> Self {
        let mut out =
            Self { crowns: Vec::new(), records: Vec::new(), draws: Vec::new(), parts: Vec::new() };
        for (model, places) in models {
            let first = out.records.len() as u32;
            let places = places.next_multiple_of(BLOCK);
            out.records.resize((first + places) as usize, no_tree());
            let draw_first = out.parts.len() as u32;
            let outlines = model.leaf_parts.iter().filter(|part| part.kind == OUTLINES).count();
            let simple = draw_first + outlines as u32;
            out.parts.extend(&model.leaf_parts);
            let wood = out.parts.len() as u32;
            out.parts.extend(&model.wood_parts);
            let end = out.parts.len() as u32;
            let (outlines, simple) = (draw_first..simple, simple..wood);
            out.draws.push(DrawRanges { outlines, simple, wood: wood..end });
            out.crowns.push(Crown {
                tree_first: first,
                draw_first,
                draw_count: end - draw_first,
                block_count: places / BLOCK,
                ..model.crown
            });
        }
        out
    }
}

impl TreeRecord {
    /// A place of the model in the forest.
    pub fn world_from_tree(&self, v: Vec3) -> Vec3 {
        let (c, s) = (self.cos_yaw, self.sin_yaw);
        let turned = Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
        self.position + turned * self.scale
    }
}
