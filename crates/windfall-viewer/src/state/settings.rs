//! What the panel sets, and how much of the running forest a change makes anew.

use windfall_gpu::{DebugView, Quality};
use windfall_scenes::Scene;

/// Everything that the panel sets and undo takes back.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The built-in scene or file that the scene came from.
    pub name: String,
    /// What is planted, when and how it is looked at. Its camera is a recorded path.
    pub scene: Scene,
    /// Leaves that fall each second over the whole forest, in place of the scene's shedding.
    pub throw_rate: Option<f32>,
    /// What colours mean.
    pub show: DebugView,
    /// The effects, each by itself; the scene's quality is the preset that they began as.
    pub quality: Quality,
}

/// What a change of the settings needs; each includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Work {
    /// Nothing but the next frame.
    Draw,
    /// Changes of the running forest: season, wind, shedding.
    Change,
    /// Another forest of the same tree models.
    Plant,
    /// Other tree models.
    Grow,
}

impl Settings {
    /// Those of a scene.
    pub fn of(name: &str, scene: Scene) -> Self {
        Self {
            name: name.to_owned(),
            quality: scene.quality_of_view(),
            scene,
            throw_rate: None,
            show: DebugView::default(),
        }
    }

    /// A built-in scene.
    pub fn named(name: &str) -> Option<Self> {
        Some(Self::of(name, windfall_scenes::named(name)?))
    }

    /// The settings to go back to: those of the built-in scene, or for a file's the present ones.
    pub fn base(&self) -> Self {
        Self::named(&self.name).unwrap_or_else(|| self.clone())
    }

    /// What it takes to come from `before` to here.
    pub fn work_from(&self, before: &Self) -> Work {
        let (a, b) = (&before.scene, &self.scene);
        let grown = |s: &Scene| (s.trees.clone(), s.seed, s.prune_order);
        if !same_models(a, b) || grown(a).1 != grown(b).1 || grown(a).2 != grown(b).2 {
            return Work::Grow;
        }
        let planted = |s: &Scene| {
            let ground = (s.terrain.relief, s.terrain.slope);
            let weights: Vec<f32> = s.trees.iter().map(|t| t.weight).collect();
            (
                (s.count, s.spacing, s.scale, s.season_spread, s.keep_out.clone(), ground, weights),
                (s.strategy, s.elimination, s.elimination_per_frame, s.leaf_occlusion),
                (s.loose_leaves, s.variation, s.fall, s.paths.clone()),
                (s.shedding.is_some(), s.sky.picture.clone()),
            )
        };
        // Leaves are thrown at a running forest, and not caught again.
        if planted(a) != planted(b) || !b.events.starts_with(&a.events) {
            return Work::Plant;
        }
        if a.events != b.events {
            return Work::Change;
        }
        let changed = |s: &Self| (s.scene.season, s.scene.wind, s.scene.shedding, s.throw_rate);
        if changed(before) == changed(self) { Work::Draw } else { Work::Change }
    }
}

fn same_models(a: &Scene, b: &Scene) -> bool {
    let models = |s: &Scene| -> Vec<_> {
        let mut trees = s.trees.clone();
        for tree in &mut trees {
            tree.weight = 1.0;
        }
        trees
    };
    models(a) == models(b)
}

/// The switches of a quality, with their names.
pub fn effects(quality: &mut Quality) -> [(&'static str, &mut bool); 12] {
    let Quality {
        soft_shadows,
        sway,
        pixel_lighting,
        veins,
        gloss,
        transmission,
        ambient_occlusion,
        ground_detail,
        bark_relief,
        grass,
        backdrop,
        resolve_filter,
        ..
    } = quality;
    [
        ("soft shadows", soft_shadows),
        ("sway", sway),
        ("lighting by pixel", pixel_lighting),
        ("veins", veins),
        ("gloss", gloss),
        ("light through leaves", transmission),
        ("ambient occlusion", ambient_occlusion),
        ("leaves on the ground", ground_detail),
        ("relief of bark", bark_relief),
        ("grass", grass),
        ("backdrop", backdrop),
        ("filtered edges", resolve_filter),
    ]
}

/// A number of a quality.
pub enum Number<'a> {
    /// A part, within bounds.
    Part(&'a mut f32, (f32, f32)),
    /// A count, within bounds.
    Count(&'a mut u32, (u32, u32)),
}

impl Number<'_> {
    /// Its value.
    pub fn get(&self) -> f32 {
        match self {
            Self::Part(value, _) => **value,
            Self::Count(value, _) => **value as f32,
        }
    }

    /// Sets it.
    ///
    /// # Errors
    ///
    /// A sentence for people, where the value is out of bounds.
    pub fn set(&mut self, to: f32) -> Result<(), String> {
        let outside = |low: f32, high: f32| format!("{to} is not from {low} to {high}");
        match self {
            Self::Part(value, (low, high)) if (*low..=*high).contains(&to) => **value = to,
            Self::Count(value, (low, high))
                if (*low as f32..=*high as f32).contains(&to) && to.fract() == 0.0 =>
            {
                **value = to as u32;
            }
            Self::Part(_, (low, high)) => return Err(outside(*low, *high)),
            Self::Count(_, (low, high)) => return Err(outside(*low as f32, *high as f32)),
        }
        Ok(())
    }
}

/// The numbers of a quality, with their names in links.
pub fn numbers(quality: &mut Quality) -> [(&'static str, Number<'_>); 3] {
    let Quality { resolution, shadow_size, shadow_taps, .. } = quality;
    [
        ("resolution", Number::Part(resolution, (0.25, 1.0))),
        ("shadow_size", Number::Count(shadow_size, (256, 2048))),
        ("shadow_taps", Number::Count(shadow_taps, (1, 16))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_scenes::Strategy;

    #[test]
    fn a_change_makes_no_more_anew_than_it_must() {
        let base = Settings::named("autumn").unwrap();
        let after = |change: &dyn Fn(&mut Settings)| {
            let mut changed = base.clone();
            change(&mut changed);
            changed.work_from(&base)
        };
        assert_eq!(after(&|_| {}), Work::Draw);
        assert_eq!(after(&|s| s.scene.sky.elevation = 3.0), Work::Draw);
        assert_eq!(after(&|s| s.scene.detail.h = 0.1), Work::Draw);
        assert_eq!(after(&|s| s.scene.season = 0.9), Work::Change);
        assert_eq!(after(&|s| s.throw_rate = Some(5.0)), Work::Change);
        assert_eq!(after(&|s| s.scene.wind.speed = 9.0), Work::Change);
        assert_eq!(after(&|s| s.scene.count = 3), Work::Plant);
        assert_eq!(after(&|s| s.scene.strategy = Strategy::Vertex), Work::Plant);
        assert_eq!(after(&|s| s.scene.trees[0].weight = 9.0), Work::Plant);
        assert_eq!(after(&|s| s.scene.shedding = None), Work::Plant);
        assert_eq!(after(&|s| s.scene.sky.picture = Some("a.hdr".into())), Work::Plant);
        assert_eq!(after(&|s| s.scene.seed = 9), Work::Grow);
        let event = windfall_scenes::EventEntry { tree: 0, leaf: 1, time: 2.0 };
        assert_eq!(after(&|s| s.scene.events = vec![event]), Work::Change);
        let mut thrown = base.clone();
        thrown.scene.events = vec![event];
        assert_eq!(base.work_from(&thrown), Work::Plant);
        assert_eq!(after(&|s| s.scene.trees[0].height = Some(9.0)), Work::Grow);
    }

    #[test]
    fn every_effect_has_a_switch() {
        let mut quality = Quality::HIGH;
        for (_, on) in effects(&mut quality) {
            *on = false;
        }
        let off = Quality {
            shadow_size: Quality::HIGH.shadow_size,
            shadow_taps: Quality::HIGH.shadow_taps,
            resolution: Quality::HIGH.resolution,
            ..quality
        };
        assert_eq!(quality, off);
        assert!(effects(&mut quality).iter().all(|(_, on)| !**on));
        assert!(!quality.sway && !quality.grass && !quality.resolve_filter && !quality.gloss);
    }
}
