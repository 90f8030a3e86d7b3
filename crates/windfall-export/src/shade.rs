//! Colours that leaves share, since many programs take no colour from instances: leaves of a group are told apart by
//! their phase of autumn, and each part has the mean colour of its leaves. Leaves with a texture have that alone.

use crate::frame::LeafState;
use crate::mesh::picture;
use crate::selection::{Group, Selection};
use glam::Vec3;

/// Shades of the leaves of a group.
pub struct Shades {
    /// Shade by phase.
    indices: [u32; SHADES],
    /// Colours of the shades; `None`: the material's own.
    pub colors: Vec<Option<Vec3>>,
}

/// Phases of autumn that are told apart.
const SHADES: usize = 12;

impl Shades {
    /// The shades in which leaves are at a time.
    pub fn of(selection: &Selection<'_>, group: &Group, time: f64) -> Self {
        let foliage = &selection.source().trees[group.kind.model as usize].foliage;
        let material = foliage.materials.get(group.kind.material as usize);
        if material.is_none_or(|material| picture(material).is_some()) {
            return Self { indices: [0; SHADES], colors: vec![None] };
        }
        let mut sums = [(Vec3::ZERO, 0.0f32); SHADES];
        for i in group.leaves.clone() {
            let state = selection.state(i, time);
            let sum = &mut sums[Self::phase(&state)];
            *sum = (sum.0 + state.color, sum.1 + 1.0);
        }
        let (mut indices, mut colors) = ([0; SHADES], Vec::new());
        for (index, (sum, count)) in indices.iter_mut().zip(sums) {
            if count > 0.0 {
                *index = colors.len() as u32;
                colors.push(Some(sum / count));
            }
        }
        Self { indices, colors }
    }

    fn phase(state: &LeafState) -> usize {
        ((state.season * SHADES as f32) as usize).min(SHADES - 1)
    }

    /// The shade of a leaf.
    pub fn index(&self, state: &LeafState) -> u32 {
        self.indices[Self::phase(state)]
    }
}
