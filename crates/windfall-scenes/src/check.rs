//! Ranges of a scene's numbers.

use crate::{Scene, Source};
use std::fmt::Display;
use windfall_core::forest::Placement;
use windfall_core::shed::Shedding;
use windfall_core::{InputError, InputErrorKind};
use windfall_tree::Species;

/// Largest width or height of a picture, pixels; a device may allow less.
const LARGEST_SIDE: u32 = 16_384;
/// Farthest that anything may be from the origin, metres.
const FARTHEST: f64 = 100_000.0;
/// Farthest moment from the scene's beginning, either way, seconds: 115 days.
const LATEST: f64 = 1e7;
/// Most leaves in the air and on the ground together.
const MOST_LEAVES: u32 = 4_000_000;

/// Name of the scene that is checked, for errors.
pub(crate) struct SceneName<'a>(pub &'a str);

impl SceneName<'_> {
    /// Refuses what is outside of `low..=high`. A NaN is in no range.
    pub fn number<T: PartialOrd + Display + Copy>(
        &self,
        place: &str,
        value: T,
        low: T,
        high: T,
    ) -> Result<(), InputError> {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(self.refuse(place, format!("{value} is not within {low} to {high}")))
        }
    }

    fn refuse(&self, place: &str, cause: String) -> InputError {
        InputError::new(self.0, place, InputErrorKind::OutOfRange, cause)
    }
}

impl Scene {
    /// Checks every number: those from a file, and those that a program or a command line changed.
    ///
    /// # Errors
    ///
    /// The first field that is out of range, with what it may be.
    pub fn check(&self, file: &str) -> Result<(), InputError> {
        let name = SceneName(file);
        let fail = |place: &str, value: String, want: &str| {
            Err(name.refuse(place, format!("{value} {want}")))
        };
        let number =
            |place: &str, value: f32, low: f32, high: f32| name.number(place, value, low, high);
        let moment = |place: &str, time: f64| name.number(place, time, -LATEST, LATEST);
        let (width, height) = self.size;
        if !(1..=LARGEST_SIDE).contains(&width) || !(1..=LARGEST_SIDE).contains(&height) {
            let want = format!("is not a picture: both sides are 1 to {LARGEST_SIDE} pixels");
            return fail("size", format!("{width}x{height}"), &want);
        }
        if self.count > Placement::MOST {
            let want = format!("is more than {} trees", Placement::MOST);
            return fail("count", self.count.to_string(), &want);
        }
        moment("time", self.time)?;
        number("fps", self.fps, 0.001, 10_000.0)?;
        if self.frames.0 > self.frames.1 {
            return fail("frames", format!("{:?}", self.frames), "ends before it begins");
        }
        if let Some(spacing) = self.spacing {
            number("spacing", spacing, 0.1, 1000.0)?;
        }
        let (small, large) = self.scale;
        if !(small > 0.0 && small <= large && large <= 100.0) {
            return fail(
                "scale",
                format!("{:?}", self.scale),
                "is not 0 < smallest <= largest <= 100",
            );
        }
        number("terrain.relief", self.terrain.relief, 0.0, 1000.0)?;
        number("terrain.slope", self.terrain.slope.0, -2.0, 2.0)?;
        number("terrain.slope", self.terrain.slope.1, -2.0, 2.0)?;
        number("terrain.meadow", self.terrain.meadow, 0.0, 1.0)?;
        number("season", self.season, 0.0, 1.0)?;
        number("season_spread", self.season_spread, 0.0, 1.0)?;
        number("sky.azimuth", self.sky.azimuth, -3600.0, 3600.0)?;
        number("sky.elevation", self.sky.elevation, 0.0, 90.0)?;
        number("sky.turbidity", self.sky.turbidity, 1.0, 10.0)?;
        number("sky.haze", self.sky.haze, 0.0, 1.0)?;
        number("sky.clouds", self.sky.clouds, 0.0, 1.0)?;
        number("sky.exposure", self.sky.exposure, -20.0, 20.0)?;
        if let Some(shedding) = &self.shedding {
            name.number("shedding.start", shedding.start, -1e6, 1e6)?;
            number("shedding.duration", shedding.duration, 0.1, 1e7)?;
            number("shedding.peak", shedding.peak, 0.0, Shedding::MOST)?;
            number("shedding.tree_spread", shedding.tree_spread, -1e6, 1e6)?;
            number("shedding.burst", shedding.burst, 0.0, Shedding::MOST)?;
        }
        number("wind.speed", self.wind.speed, 0.0, 40.0)?;
        number("wind.heading", self.wind.heading, -3600.0, 3600.0)?;
        number("wind.gustiness", self.wind.gustiness, 0.0, 1.0)?;
        self.variation.check(&name)?;
        self.fall.check(&name)?;
        for (i, path) in self.paths.iter().enumerate() {
            number(&format!("paths[{i}].scale"), path.scale, 1e-6, 1e6)?;
            number(&format!("paths[{i}].fps"), path.fps.unwrap_or(1.0), 1e-3, 1e5)?;
            number(&format!("paths[{i}].rate"), path.rate.unwrap_or(60.0), 1.0, 1e4)?;
        }
        name.number("loose_leaves", self.loose_leaves, 0, MOST_LEAVES)?;
        if let Some(budget) = self.budget {
            name.number("budget", budget, 0.1, 10_000.0)?;
        }
        name.number("elimination_per_frame", self.elimination_per_frame, 1, MOST_LEAVES)?;
        let rules = self.leaf_occlusion_rules;
        name.number("leaf_occlusion_rules.one_in", rules.one_in, 1, 8)?;
        name.number("leaf_occlusion_rules.skip", rules.skip, 1, 7)?;
        name.number("leaf_occlusion_rules.pixels", rules.pixels, 1, 1000)?;
        if self.trails.len() > 4 {
            return fail("trails", self.trails.len().to_string(), "are more than 4");
        }
        let strips = self.keep_out.iter().enumerate().map(|s| ("keep_out", s));
        for (list, (i, strip)) in
            strips.chain(self.trails.iter().enumerate().map(|s| ("trails", s)))
        {
            let place = format!("{list}[{i}]");
            for value in [strip.from.0, strip.from.1, strip.to.0, strip.to.1] {
                name.number(&place, value, -FARTHEST, FARTHEST)?;
            }
            number(&place, strip.radius, 0.0, 1000.0)?;
        }
        for (i, event) in self.events.iter().enumerate() {
            moment(&format!("events[{i}].time"), event.time)?;
        }
        self.check_detail(&name)?;
        self.check_trees(file)?;
        if self.camera.is_empty() {
            return fail("camera", "the list".to_owned(), "has no key");
        }
        for (i, key) in self.camera.iter().enumerate() {
            let at = |field: &str| format!("camera[{i}]{field}");
            for (field, (x, y, z)) in [(".eye", key.eye), (".target", key.target)] {
                for value in [x, y, z] {
                    name.number(&at(field), value, -FARTHEST, FARTHEST)?;
                }
            }
            number(&at(".fov"), key.fov, 1.0, 170.0)?;
            moment(&at(".time"), key.time)?;
            if key.eye == key.target {
                return Err(name.refuse(&at(""), "eye and target are the same".to_owned()));
            }
            if i > 0 && key.time <= self.camera[i - 1].time {
                return fail(&at(".time"), key.time.to_string(), "is not after the key before it");
            }
        }
        Ok(())
    }

    fn check_trees(&self, file: &str) -> Result<(), InputError> {
        let fail =
            |place: String, kind, cause: String| Err(InputError::new(file, place, kind, cause));
        let species = |place: String, name: &str| match name.parse::<Species>() {
            Ok(_) => Ok(()),
            Err(unknown) => fail(place, InputErrorKind::Missing, unknown.to_string()),
        };
        if self.trees.is_empty() && self.count > 0 {
            let cause = format!("no tree to plant {} of", self.count);
            return fail("trees".into(), InputErrorKind::Empty, cause);
        }
        for (i, tree) in self.trees.iter().enumerate() {
            let place = |field: &str| format!("trees[{i}].{field}");
            if let Source::Species(name) = &tree.source {
                species(place("source"), name)?;
            }
            if let Some(name) = &tree.palette {
                species(place("palette"), name)?;
            }
            let out_of_range = |field, value: f32, want: &str| {
                fail(place(field), InputErrorKind::OutOfRange, format!("{value} is not {want}"))
            };
            if !(tree.weight > 0.0 && tree.weight <= 1e6) {
                return out_of_range("weight", tree.weight, "above 0");
            }
            if !(1..=16).contains(&tree.variants) {
                return out_of_range("variants", tree.variants as f32, "1 to 16");
            }
            if let Some(unit) = tree.unit
                && !(1e-6..=1e6).contains(&unit)
            {
                return out_of_range("unit", unit, "0.000001 to 1000000 metres");
            }
            if let Some(height) = tree.height
                && !(0.01..=1000.0).contains(&height)
            {
                return out_of_range("height", height, "0.01 to 1000 metres");
            }
        }
        Ok(())
    }
}
