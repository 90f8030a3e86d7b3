//! Occlusion culling where it pays.

use crate::counts::TreeCounts;
use crate::view::culling::Culling;
use crate::view::description::View;

/// Share of the leaves in view, by λ, that has to be hidden: below, drawing in two passes and the pyramid between them
/// cost more than is saved.
const PAYS: f32 = 0.15;
/// Counted frames of a try: in the first the pyramid is of another view or of none, and counts may be some frames old.
const TRY: u32 = 6;
/// Counted frames until the next try.
const REST: u32 = 120;

/// Uses [`Culling::Occlusion`] where it pays, and [`Culling::Sphere`] where it does not: in six frames of every 126 it is
/// tried, and kept for as long as a seventh of the leaves in view is hidden. The picture is the same in either case.
///
/// It changes a copy of the view, as [`crate::FrameBudget`] does, and knows what it is told: a host that counts
/// ([`crate::CountReadback`]) passes on what comes back, however late.
///
/// ```
/// # use windfall_gpu::{Camera, Culling, OcclusionSwitch, TreeCounts, View};
/// # use glam::DVec3;
/// let mut occlusion = OcclusionSwitch::default();
/// let mut wanted = View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 0.9, 0.1));
/// wanted.culling = Culling::Occlusion;
/// for _ in 0..20 {
///     let mut view = wanted.clone();
///     occlusion.apply(&mut view);
///     // Draw the view; on open ground nothing was hidden.
///     occlusion.counted(&TreeCounts { leaves_by_lambda: 100, ..TreeCounts::default() });
/// }
/// let mut view = wanted.clone();
/// occlusion.apply(&mut view);
/// assert_eq!(view.culling, Culling::Sphere);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OcclusionSwitch {
    /// Whether the last view asked for it.
    wanted: bool,
    /// Whether it rests; else it is tried or pays.
    rests: bool,
    /// Counted frames since that began.
    frames: u32,
    /// The largest share of hidden leaves in this try.
    share: f32,
}

impl OcclusionSwitch {
    /// Switches a view's occlusion culling off where it does not pay. Views without it stay as they are.
    pub fn apply(&mut self, view: &mut View) {
        // Pictures of fewer pixels have none.
        let wanted = view.culling == Culling::Occlusion && view.quality.resolution >= 1.0;
        if wanted && self.rests {
            view.culling = Culling::Sphere;
        }
        self.wanted = wanted;
    }

    /// What a frame drew.
    pub fn counted(&mut self, trees: &TreeCounts) {
        if !self.wanted {
            return;
        }
        self.frames += 1;
        if self.rests {
            if self.frames >= REST {
                *self = Self { wanted: true, ..Self::default() };
            }
            return;
        }
        let hidden = trees.hidden_leaves_by_lambda;
        let all = trees.leaves_by_lambda + hidden;
        self.share = self.share.max(hidden as f32 / all.max(1) as f32);
        if self.frames >= TRY {
            let rests = self.share < PAYS;
            *self = Self { wanted: true, rests, ..Self::default() };
        }
    }

    /// Whether it is being tried or pays.
    pub fn is_on(&self) -> bool {
        !self.rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::camera::Camera;
    use crate::view::quality::Quality;
    use glam::DVec3;

    fn view(culling: Culling) -> View {
        View { culling, ..View::new(Camera::look_at(DVec3::ZERO, DVec3::X, 0.9, 0.1)) }
    }

    /// Frames out of `count` that were drawn with occlusion culling, where `hidden` of a hundred leaves are.
    fn used(switch: &mut OcclusionSwitch, count: u32, hidden: u64) -> u32 {
        let mut used = 0;
        for _ in 0..count {
            let mut view = view(Culling::Occlusion);
            switch.apply(&mut view);
            let on = view.culling == Culling::Occlusion;
            used += u32::from(on);
            let hidden = if on { hidden } else { 0 };
            switch.counted(&TreeCounts {
                leaves_by_lambda: 100 - hidden,
                hidden_leaves_by_lambda: hidden,
                ..Default::default()
            });
        }
        used
    }

    #[test]
    fn it_stays_where_it_pays_and_is_tried_where_it_does_not() {
        let mut switch = OcclusionSwitch::default();
        assert_eq!(used(&mut switch, 1000, 40), 1000);
        // Out of the valley: within a try it is off, and tried again from time to time.
        assert!(used(&mut switch, 12, 5) <= 12 && !switch.is_on());
        assert_eq!(used(&mut switch, 10 * (TRY + REST), 5), 10 * TRY);
        // Back in the valley.
        used(&mut switch, TRY + REST, 40);
        assert_eq!(used(&mut switch, 1000, 40), 1000);
    }

    #[test]
    fn other_views_are_left_alone_and_tell_nothing() {
        let mut switch = OcclusionSwitch::default();
        for _ in 0..500 {
            let mut sphere = view(Culling::Sphere);
            switch.apply(&mut sphere);
            switch.counted(&TreeCounts { leaves_by_lambda: 100, ..Default::default() });
            assert_eq!(sphere, view(Culling::Sphere));
            let mut coarse = View { quality: Quality::LOW, ..view(Culling::Occlusion) };
            switch.apply(&mut coarse);
            switch.counted(&TreeCounts { leaves_by_lambda: 100, ..Default::default() });
        }
        assert_eq!(used(&mut switch, 1, 0), 1);
    }
}
