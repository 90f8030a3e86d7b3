//! How leaves fall: their paths, how falls on the same path differ, how they begin and end.

use crate::Stage;
use crate::check::SceneName;
use crate::choices::TimeUnit;
use serde::{Deserialize, Serialize};
use windfall_core::InputError;
use windfall_core::path::{Edition, FallPath, FallSettings, Hashed, PathSet, Variation};
use windfall_tree::Up;

/// Name of the group of paths that are for every tree without paths of its own.
const ANY: &str = "any tree";

/// A file of fall paths: a glTF animation, a table, or a path set. The caller reads it; see [`Stage::fall_by`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathEntry {
    /// The file, relative to the scene file.
    pub file: String,
    /// Species, or tree files, whose leaves fall by it; empty: all trees that no other entry names.
    #[serde(default)]
    pub trees: Vec<String>,
    /// glTF: the animated node, where there are several.
    #[serde(default)]
    pub node: Option<String>,
    /// glTF: the animation ("take"); `None`: the first.
    #[serde(default)]
    pub animation: Option<String>,
    /// The axis that points up in the file.
    #[serde(default)]
    pub up: Up,
    /// Metres for each unit of the file.
    #[serde(default = "one")]
    pub scale: f32,
    /// Tables with frame numbers: frames per second.
    #[serde(default)]
    pub fps: Option<f32>,
    /// Tables: what times are in.
    #[serde(default)]
    pub time_unit: TimeUnit,
    /// Samples per second to resample to.
    #[serde(default)]
    pub rate: Option<f32>,
}

fn one() -> f32 {
    1.0
}

impl PathEntry {
    /// An entry with every option at its default.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            trees: Vec::new(),
            node: None,
            animation: None,
            up: Up::Y,
            scale: 1.0,
            fps: None,
            time_unit: TimeUnit::Seconds,
            rate: None,
        }
    }
}

/// How falls on the same path differ: see [`Variation`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum VariationEntry {
    /// From the leaf's hash, within these bounds.
    Hashed {
        /// Smallest and largest factor on horizontal displacements.
        scale: (f32, f32),
        /// Slowest and fastest playback.
        rate: (f32, f32),
    },
    /// The formulas of Vázquez and Balsa, as the text of this year prints them: 2007 or 2008.
    Paper(u16),
}

impl Default for VariationEntry {
    fn default() -> Self {
        let Hashed { scale, rate } = Hashed::default();
        Self::Hashed { scale: (scale.start, scale.end), rate: (rate.start, rate.end) }
    }
}

impl VariationEntry {
    pub(crate) fn variation(self) -> Variation {
        match self {
            Self::Hashed { scale, rate } => {
                Variation::Hashed(Hashed { scale: scale.0..scale.1, rate: rate.0..rate.1 })
            }
            Self::Paper(2007) => Variation::Paper(Edition::Of2007),
            Self::Paper(_) => Variation::Paper(Edition::Of2008),
        }
    }

    pub(crate) fn check(self, name: &SceneName<'_>) -> Result<(), InputError> {
        match self {
            Self::Hashed { scale, rate } => {
                for (place, (low, high), least) in
                    [("variation.scale", scale, 0.0), ("variation.rate", rate, 0.1)]
                {
                    name.number(place, low, least, 10.0)?;
                    name.number(place, high, low, 10.0)?;
                }
                Ok(())
            }
            Self::Paper(year) => name.number("variation.Paper", year, 2007, 2008),
        }
    }
}

/// How a fall begins and ends: see [`FallSettings`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FallEntry {
    /// Drop over which the orientation eases from the twig's into the path's.
    pub soft_drop: f32,
    /// Time over which the fall starts from rest.
    pub soft_time: f32,
    /// Time before landing over which the orientation eases to lie on the ground.
    pub settle_time: f32,
    /// Most by which a leaf turns while it settles, degrees.
    pub settle_turn: f32,
    /// Time constant with which a leaf takes on the wind's speed.
    pub wind_response: f32,
}

impl Default for FallEntry {
    fn default() -> Self {
        let s = FallSettings::default();
        Self {
            soft_drop: s.soft_drop,
            soft_time: s.soft_time,
            settle_time: s.settle_time,
            settle_turn: s.settle_turn.to_degrees(),
            wind_response: s.wind_response,
        }
    }
}

impl FallEntry {
    pub(crate) fn settings(&self) -> FallSettings {
        FallSettings {
            soft_drop: self.soft_drop,
            soft_time: self.soft_time,
            settle_time: self.settle_time,
            settle_turn: self.settle_turn.to_radians(),
            wind_response: self.wind_response,
        }
    }

    pub(crate) fn check(&self, name: &SceneName<'_>) -> Result<(), InputError> {
        name.number("fall.soft_drop", self.soft_drop, 0.0, 100.0)?;
        name.number("fall.soft_time", self.soft_time, 0.0, 10.0)?;
        name.number("fall.settle_time", self.settle_time, 0.0, 10.0)?;
        name.number("fall.settle_turn", self.settle_turn, 0.0, 360.0)?;
        name.number("fall.wind_response", self.wind_response, 0.01, 10.0)
    }
}

impl Stage {
    /// Lets leaves fall by the paths of files, in place of the built-in ones. Each list of paths comes with the trees
    /// that it is for, as [`PathEntry::trees`] has them; without any it is for all trees that no other list
    /// names. Paths for all trees keep their own names where these are names of trees, as in a path set by species.
    ///
    /// # Errors
    ///
    /// A list for a tree that the stage has not, or more paths than a set may have.
    pub fn fall_by(&mut self, lists: Vec<(Vec<String>, Vec<FallPath>)>) -> Result<(), InputError> {
        let (mut general, mut own) = (Vec::new(), Vec::new());
        for (trees, paths) in lists {
            if trees.is_empty() {
                general.extend(paths.into_iter().map(|path| {
                    let named = self.trees.iter().any(|tree| tree.name == path.name());
                    if named { path } else { path.renamed(ANY) }
                }));
                continue;
            }
            for asked in &trees {
                let mut models: Vec<&str> = self.trees.iter().map(|t| t.name.as_str()).collect();
                models.dedup();
                let found: Vec<&str> = models.iter().copied().filter(|m| is(m, asked)).collect();
                if found.is_empty() {
                    let cause = format!("no tree is {asked:?}; there are {}", models.join(", "));
                    let kind = windfall_core::InputErrorKind::Missing;
                    return Err(InputError::new("paths", "trees", kind, cause));
                }
                let of =
                    |name: &str| paths.iter().map(|p| p.clone().renamed(name)).collect::<Vec<_>>();
                own.extend(found.into_iter().flat_map(of));
            }
        }
        let mut all = if general.is_empty() { self.falls.paths.paths().to_vec() } else { general };
        all.retain(|path| !own.iter().any(|own| own.name() == path.name()));
        // The first group is for every tree that has none.
        all.sort_by_key(|path| path.name() != ANY);
        all.extend(own);
        self.falls.paths = PathSet::new(all)?;
        Ok(())
    }
}

/// Whether a tree's name is the one that is asked for: a species, or a file with or without its folder and ending.
fn is(tree: &str, asked: &str) -> bool {
    let file = tree.rsplit(['/', '\\']).next().unwrap_or(tree);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    [tree, file, stem].contains(&asked) || tree.ends_with(&format!("/{asked}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage() -> Stage {
        let text = r#"(version: 1, count: 2, camera: [(eye: (0, 1.7, 20), target: (0, 5, 0))],
            trees: [(source: Species("oak"), variants: 1), (source: Species("birch"), variants: 1)])"#;
        let scene = crate::Scene::from_ron(text, "s.ron").unwrap();
        scene.build(|_, _| -> Result<_, String> { Err("no files".into()) }).unwrap()
    }

    fn path(name: &str) -> FallPath {
        PathSet::builtin().paths()[0].clone().renamed(name)
    }

    #[test]
    fn paths_are_for_all_trees_or_for_some() {
        let mut stage = stage();
        stage.fall_by(vec![(Vec::new(), vec![path("fall")])]).unwrap();
        assert_eq!(stage.falls.paths.groups(), [ANY]);
        stage.fall_by(vec![(vec!["oak".into()], vec![path("fall"), path("storm")])]).unwrap();
        let set = &stage.falls.paths;
        assert_eq!(set.groups(), [ANY, "oak"]);
        assert_eq!((stage.falls.group_of("oak"), stage.falls.group_of("birch")), (1, 0));
        assert_eq!(set.paths().len(), 3);
        // The built-in paths stay for those that are not named.
        let mut other = self::stage();
        other.fall_by(vec![(vec!["oak".into()], vec![path("fall")])]).unwrap();
        let builtin = PathSet::builtin();
        assert_eq!(other.falls.paths.groups().len(), builtin.groups().len());
        let set = &other.falls.paths;
        let of = |name: &str| set.paths().iter().filter(|p| p.name() == name).count();
        assert_eq!(of("oak"), 1);
        assert!(of("birch") > 1);
        let error = other.fall_by(vec![(vec!["fir".into()], vec![path("fall")])]).unwrap_err();
        assert!(error.to_string().contains("no tree is \"fir\"; there are oak, birch"), "{error}");
    }

    #[test]
    fn trees_are_named_by_species_or_file() {
        assert!(
            is("oak", "oak") && is("/a/b/my_oak.glb", "my_oak.glb") && is("a/my_oak.glb", "my_oak")
        );
        assert!(is("/x/a/my_oak.glb", "a/my_oak.glb"));
        assert!(!is("oak", "my_oak") && !is("my_oak.glb", "oak"));
    }

    #[test]
    fn a_scene_says_how_falls_differ() {
        let text = r#"(version: 1, count: 1, trees: [(source: Species("oak"))], variation: Paper(2007),
            fall: (soft_drop: 0.5, settle_turn: 90), paths: [(file: "a.glb", trees: ["oak"], time_unit: "ms")],
            camera: [(eye: (0, 1.7, 20), target: (0, 5, 0))])"#;
        let scene = crate::Scene::from_ron(text, "s.ron").unwrap();
        assert_eq!(crate::Scene::from_ron(&scene.to_ron(), "s.ron").unwrap(), scene);
        assert_eq!(scene.variation.variation(), Variation::Paper(Edition::Of2007));
        let settings = scene.fall.settings();
        assert_eq!(
            (settings.soft_drop, settings.soft_time),
            (0.5, FallSettings::default().soft_time)
        );
        assert!((settings.settle_turn - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        assert_eq!(scene.paths[0].time_unit, TimeUnit::Milliseconds);
        let error = |from: &str, to: &str| {
            crate::Scene::from_ron(&text.replace(from, to), "s.ron").unwrap_err().to_string()
        };
        assert!(error("2007", "2009").contains("variation.Paper: 2009 is not within 2007 to 2008"));
        assert!(error("0.5", "-1").contains("fall.soft_drop"));
        assert!(error("\"ms\"", "\"h\"").contains("s, ms"));
    }
}
