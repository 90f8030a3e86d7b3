//! Named scenes and the scene file: what to plant, where, when, and how it is looked at.
//!
//! A scene is a versioned RON file ([`Scene::from_ron`]); the built-in ones are such files too and
//! serve the tests, the benchmarks and the README's pictures. Nothing here opens a file: trees that
//! a scene names are read by the caller.
//!
//! A scene that was read is whole: its choices are enums and its numbers are in range, so nothing is
//! parsed later. A program that changes one calls [`Scene::check`].
//!
//! | from | by | comes |
//! |---|---|---|
//! | a scene | [`Scene::build`], or [`Scene::models`] and [`Scene::place`] | a [`Stage`]: trees, their places and how their leaves fall |
//! | a stage and a device | [`Stage::upload`] | a [`PlantedStage`]: the forest |
//! | a scene and a moment | [`Scene::view`] | a [`windfall_gpu::View`] |
//! | forest, moment and view | [`PlantedStage::render`] | a picture, by the scene's strategy |
#![deny(missing_docs)]

mod check;
mod choices;
mod detail;
mod falling;
mod named;
mod planted;
mod stage;
mod throw;

pub use choices::{
    Culling, Elimination, LandingSearch, QualityPreset, Strategy, TimeUnit, UnknownChoice,
};
pub use detail::read_detail;
pub use falling::{FallEntry, PathEntry, VariationEntry};
pub use named::{NAMES, named};
pub use planted::{PlantedStage, StageCounts, StageError, StageReadback};
pub use stage::{Model, Stage};

use serde::{Deserialize, Serialize};
use windfall_core::shed::Shedding;
use windfall_core::simplify::{PruneOrder, Simplification};
use windfall_core::{InputError, InputErrorKind};
use windfall_papers::LeafOcclusion;
use windfall_tree::{ImportOptions, Up};

/// The version that this library reads and writes.
pub const VERSION: u32 = 1;

/// Everything that a picture is made from, but for the tree files themselves.
///
/// Lengths are in metres, times in seconds, angles in degrees (the only place where they are).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the format: [`VERSION`].
    pub version: u32,
    /// One line for people.
    #[serde(default)]
    pub about: String,
    /// Key of everything random.
    #[serde(default)]
    pub seed: u32,
    /// Width and height of the picture, pixels.
    #[serde(default = "defaults::size")]
    pub size: (u32, u32),
    /// Time of a still, seconds.
    #[serde(default)]
    pub time: f64,
    /// First and last frame of a film.
    #[serde(default = "defaults::frames")]
    pub frames: (u32, u32),
    /// Frames per second: frame `n` is the moment `n / fps`.
    #[serde(default = "defaults::fps")]
    pub fps: f32,
    /// What is planted.
    pub trees: Vec<TreeEntry>,
    /// Trees of the forest, 0 to 100,000.
    pub count: u32,
    /// Least distance between trunks; `None`: three quarters of the mean crown's width.
    #[serde(default)]
    pub spacing: Option<f32>,
    /// Smallest and largest factor on a tree's size.
    #[serde(default = "defaults::scale")]
    pub scale: (f32, f32),
    /// Where no trunk may stand.
    #[serde(default)]
    pub keep_out: Vec<Capsule>,
    /// Trodden paths, up to four.
    #[serde(default)]
    pub trails: Vec<Capsule>,
    /// The ground.
    #[serde(default)]
    pub terrain: Ground,
    /// Phase of autumn, 0 late summer to 1 bare.
    #[serde(default = "defaults::season")]
    pub season: f32,
    /// Largest season offset of a tree, either way.
    #[serde(default = "defaults::season_spread")]
    pub season_spread: f32,
    /// When leaves fall; `None`: no leaf does.
    #[serde(default = "defaults::shedding")]
    pub shedding: Option<SheddingEntry>,
    /// What carries them.
    #[serde(default)]
    pub wind: WindEntry,
    /// Files of fall paths in place of the built-in ones.
    #[serde(default)]
    pub paths: Vec<PathEntry>,
    /// How falls on the same path differ.
    #[serde(default)]
    pub variation: VariationEntry,
    /// How falls begin and end.
    #[serde(default)]
    pub fall: FallEntry,
    /// Most leaves in the air and on the ground together.
    #[serde(default = "defaults::loose_leaves")]
    pub loose_leaves: u32,
    /// Where the poses of falling leaves are computed.
    #[serde(default)]
    pub strategy: Strategy,
    /// Which leaves a simplified tree keeps: the first in this order, `"random"`, `"importance"` or
    /// `"blue-noise"`.
    #[serde(default)]
    pub prune_order: PruneOrder,
    /// When landed leaves become static geometry.
    #[serde(default)]
    pub elimination: Elimination,
    /// Leaves that [`Elimination::Progressive`] tests in a frame, at least 1; VB: 10 to 20.
    #[serde(default = "defaults::elimination_per_frame")]
    pub elimination_per_frame: u32,
    /// Whether leaves in the air that are not seen are skipped for some frames. Frames then depend a
    /// little on those that were drawn before. [`Strategy::Compute`] ignores it.
    #[serde(default)]
    pub leaf_occlusion: bool,
    /// How many leaves are tested for it, how long they are skipped, and from which size on they are seen.
    #[serde(default)]
    pub leaf_occlusion_rules: OcclusionEntry,
    /// Who looks for the place where a leaf lands. [`Strategy::Compute`] and [`Strategy::Cpu`] ignore it.
    #[serde(default)]
    pub landing_search: LandingSearch,
    /// Leaves that detach at a moment of their own, beside those of the season.
    #[serde(default)]
    pub events: Vec<EventEntry>,
    /// The camera's way, by rising time; before the first and after the last key it stands still.
    pub camera: Vec<CameraKey>,
    /// Sun and air.
    #[serde(default)]
    pub sky: SkyEntry,
    /// Whether the sun casts shadows.
    #[serde(default = "defaults::yes")]
    pub shadows: bool,
    /// How distant trees are simplified. A file has the options in one list:
    ///
    /// | key | option |
    /// |---|---|
    /// | `d0`, or `b0: Some(…)` | [`Simplification::reduction`] |
    /// | `growth_factor`, `growth_pixels` | [`Simplification::growth`]; the factor is `Some(…)`, or `None` for any |
    /// | `fade`, `fade_range`, `full_at_one`, `early`, `smooth` | [`Simplification::fade`] |
    /// | the others | the field of the same name |
    #[serde(default, with = "detail")]
    pub detail: Simplification,
    /// How those are simplified that cast shadows; the keys are the same. Left out as a whole, trees
    /// are drawn in full up to 15 m; what a list leaves out is as in [`Simplification::DEFAULT`].
    #[serde(default = "stage::shadow_detail", with = "detail")]
    pub shadow_detail: Simplification,
    /// Which trees are left out because they are not seen.
    #[serde(default)]
    pub culling: Culling,
    /// Whether leaves inside of crowns are darker under the sky (VB 7.1); `None`: as `quality` says.
    #[serde(default)]
    pub ambient_occlusion: Option<bool>,
    /// Milliseconds that a frame should take, 0.1 to 10,000: what [`windfall_gpu::FrameBudget`] gives up then depends on
    /// the machine. `None`: frames are as they are, and the same each time.
    #[serde(default)]
    pub budget: Option<f32>,
    /// What the picture may cost.
    #[serde(default)]
    pub quality: QualityPreset,
}

/// A kind of tree in the forest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeEntry {
    /// Where the model comes from.
    pub source: Source,
    /// Share of the forest relative to the other entries' weights.
    #[serde(default = "defaults::one")]
    pub weight: f32,
    /// Different models of a species, 1 to 16; a file is one.
    #[serde(default = "defaults::variants")]
    pub variants: u32,
    /// Height that the model is scaled to; `None`: its own.
    #[serde(default)]
    pub height: Option<f32>,
    /// Nodes of a file to read, by name or number; empty: all of it.
    #[serde(default)]
    pub node: Vec<String>,
    /// Nodes, meshes or materials of a file that are leaves, by name, or numbers of primitives; empty: found by
    /// name and alpha.
    #[serde(default)]
    pub leaves: Vec<String>,
    /// The same that are wood.
    #[serde(default)]
    pub wood: Vec<String>,
    /// The axis that points up in a file.
    #[serde(default)]
    pub up: Up,
    /// Metres for each unit of a file; `None`: 1.
    #[serde(default)]
    pub unit: Option<f32>,
    /// Whether the lowest point of a file's tree stands on the ground.
    #[serde(default)]
    pub ground: bool,
    /// Whether colours of vertices are colours.
    #[serde(default = "defaults::yes")]
    pub vertex_colors: bool,
    /// Species whose autumn colours the leaves of a file take; `None`: their own colour.
    #[serde(default)]
    pub palette: Option<String>,
}

/// Where a tree model comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// A built-in species, by name.
    Species(String),
    /// A glTF file, relative to the scene file.
    File(String),
}

/// A strip of ground with round ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Capsule {
    /// One end, `(x, z)`.
    pub from: (f64, f64),
    /// The other end.
    pub to: (f64, f64),
    /// Half width.
    pub radius: f32,
}

/// The ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Height of the hills; 0 is level.
    pub relief: f32,
    /// Rise along x and z, metres per metre.
    pub slope: (f32, f32),
    /// What grows on it: 0 bare of grass, 1 a meadow.
    pub meadow: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { relief: 2.5, slope: (0.0, 0.0), meadow: 0.4 }
    }
}

/// When leaves detach: see [`windfall_core::shed::Shedding`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SheddingEntry {
    /// When a tree's first leaf detaches; may lie before the scene.
    pub start: f64,
    /// Time from a tree's first leaf to its last.
    pub duration: f32,
    /// How much leaves gather in the middle of that time, 0 to 0.95.
    pub peak: f32,
    /// Seconds by which a tree of season offset 1 is early.
    pub tree_spread: f32,
    /// How much leaves gather in gusts, 0 to 0.95.
    pub burst: f32,
}

impl Default for SheddingEntry {
    fn default() -> Self {
        let s = Shedding::default();
        Self {
            start: s.start,
            duration: s.duration,
            peak: s.peak,
            tree_spread: s.tree_spread,
            burst: s.burst,
        }
    }
}

/// A leaf that is thrown: see [`windfall_gpu::Forest::throw`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventEntry {
    /// Number of the tree, from 0, in the order of planting.
    pub tree: u32,
    /// Number of the leaf on it, from 0, in prune order.
    pub leaf: u32,
    /// When it detaches.
    pub time: f64,
}

/// Leaf occlusion: see [`windfall_papers::LeafOcclusion`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OcclusionEntry {
    /// One of so many leaves that are seen is tested in a frame, 1 to 8.
    pub one_in: u32,
    /// Frames for which a leaf that is not seen is skipped, 1 to 7; VB: 2 to 4.
    pub skip: u32,
    /// Pixels from which on a leaf is seen, 1 to 1000.
    pub pixels: u32,
}

impl Default for OcclusionEntry {
    fn default() -> Self {
        let LeafOcclusion { one_in, skip, pixels } = LeafOcclusion::default();
        Self { one_in, skip, pixels }
    }
}

impl From<OcclusionEntry> for LeafOcclusion {
    fn from(OcclusionEntry { one_in, skip, pixels }: OcclusionEntry) -> Self {
        Self { one_in, skip, pixels }
    }
}

/// A wind with gusts: see [`windfall_core::wind::Wind::new`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WindEntry {
    /// Metres per second.
    pub speed: f32,
    /// Direction that it blows to: 0 is +X, 90 is +Z.
    pub heading: f32,
    /// Largest gust over the speed, 0 to 1.
    pub gustiness: f32,
}

impl Default for WindEntry {
    fn default() -> Self {
        Self { speed: 1.2, heading: 30.0, gustiness: 0.6 }
    }
}

/// The camera at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// When.
    #[serde(default)]
    pub time: f64,
    /// Where it stands: x, height above the ground there, z.
    pub eye: (f64, f64, f64),
    /// What it looks at: x, height above the ground there, z.
    pub target: (f64, f64, f64),
    /// Vertical field of view, degrees.
    #[serde(default = "defaults::fov")]
    pub fov: f32,
}

/// Sun and air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SkyEntry {
    /// Direction of the sun seen from above: 0 is +Z, 90 is +X.
    pub azimuth: f32,
    /// Height of the sun, 0 to 90.
    pub elevation: f32,
    /// Haze over clear air high above, 1 to 10: 2 is a clear day.
    pub turbidity: f32,
    /// Extinction of the air near the ground, 1/m.
    pub haze: f32,
    /// Share of the sky that thin clouds cover, 0 to 1.
    pub clouds: f32,
    /// Exposure, stops.
    pub exposure: f32,
    /// An equirectangular picture of the sky, `.hdr` or `.exr`, relative to the scene file: in place
    /// of the model's as background and ambient light. Azimuth and elevation are to be its sun's.
    pub picture: Option<String>,
}

impl Default for SkyEntry {
    fn default() -> Self {
        Self {
            azimuth: 40.0,
            elevation: 32.0,
            turbidity: 2.2,
            haze: 0.0008,
            clouds: 0.35,
            exposure: 0.0,
            picture: None,
        }
    }
}

mod defaults {
    pub fn yes() -> bool {
        true
    }
    #[expect(clippy::unnecessary_wraps, reason = "serde wants the field's type")]
    pub fn shedding() -> Option<super::SheddingEntry> {
        Some(super::SheddingEntry::default())
    }
    pub fn loose_leaves() -> u32 {
        1_000_000
    }
    pub fn elimination_per_frame() -> u32 {
        20
    }
    pub fn size() -> (u32, u32) {
        (1280, 720)
    }
    pub fn frames() -> (u32, u32) {
        (0, 299)
    }
    pub fn fps() -> f32 {
        30.0
    }
    pub fn scale() -> (f32, f32) {
        (0.8, 1.15)
    }
    pub fn season() -> f32 {
        0.55
    }
    pub fn season_spread() -> f32 {
        0.12
    }
    pub fn one() -> f32 {
        1.0
    }
    pub fn variants() -> u32 {
        2
    }
    pub fn fov() -> f32 {
        50.0
    }
}

impl TreeEntry {
    /// An entry with every option at its default.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            weight: defaults::one(),
            variants: defaults::variants(),
            height: None,
            node: Vec::new(),
            leaves: Vec::new(),
            wood: Vec::new(),
            up: Up::Y,
            unit: None,
            ground: false,
            vertex_colors: true,
            palette: None,
        }
    }

    /// How the entry's file is read.
    pub fn import_options(&self) -> ImportOptions {
        ImportOptions {
            node: self.node.clone(),
            leaves: self.leaves.clone(),
            wood: self.wood.clone(),
            up: self.up,
            unit: self.unit,
            ground: self.ground,
            vertex_colors: self.vertex_colors,
            height: self.height,
            ..ImportOptions::default()
        }
    }
}

impl Scene {
    /// Calls `with` with the name of each file that the scene needs: trees, fall paths, the picture of the sky.
    pub fn each_file(&mut self, mut with: impl FnMut(&mut String)) {
        for tree in &mut self.trees {
            if let Source::File(name) = &mut tree.source {
                with(name);
            }
        }
        self.paths.iter_mut().for_each(|path| with(&mut path.file));
        self.sky.picture.iter_mut().for_each(with);
    }

    /// Reads a scene. `file` is its name in errors.
    ///
    /// # Errors
    ///
    /// What is not RON, has unknown fields or names, or another version: with the line and column.
    /// Numbers out of range, and species that there are not: with the field.
    pub fn from_ron(text: &str, file: &str) -> Result<Self, InputError> {
        let spanned = |e: ron::error::SpannedError| {
            let place = format!("line {}, column {}", e.span.start.line, e.span.start.col);
            InputError::new(file, place, InputErrorKind::Malformed, e.code.to_string())
        };
        // The version first: a file of another version may have fields that this one has not.
        let version: Version = ron::from_str(text).map_err(spanned)?;
        if version.version != VERSION {
            return Err(InputError::new(
                file,
                "version",
                InputErrorKind::Unsupported,
                format!(
                    "version {} is not known; this program reads version {VERSION}",
                    version.version
                ),
            ));
        }
        let scene: Self = ron::from_str(text).map_err(spanned)?;
        scene.check(file)?;
        Ok(scene)
    }

    /// The scene as a file.
    ///
    /// # Panics
    ///
    /// Never: every scene can be written.
    pub fn to_ron(&self) -> String {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::default())
            .expect("a scene holds only numbers, strings and lists")
    }
}

/// The one field that every version has.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_core::simplify::Reduction;

    const SMALL: &str = r#"(version: 1, trees: [(source: Species("oak"))], count: 3,
        camera: [(eye: (0, 1.7, 20), target: (0, 5, 0))])"#;

    fn error(from: &str, to: &str) -> String {
        assert!(SMALL.contains(from), "{from}");
        Scene::from_ron(&SMALL.replace(from, to), "s.ron").unwrap_err().to_string()
    }

    #[test]
    fn each_file_is_named() {
        let text = SMALL.replace(
            r#"trees: [(source: Species("oak"))]"#,
            r#"trees: [(source: Species("oak")), (source: File("a.glb"))], paths: [(file: "b.csv")]"#,
        );
        let text = text.replace("count: 3", r#"count: 3, sky: (picture: Some("c.hdr"))"#);
        let mut scene = Scene::from_ron(&text, "s.ron").unwrap();
        scene.each_file(|name| name.insert_str(0, "x/"));
        let mut names = Vec::new();
        scene.each_file(|name| names.push(name.clone()));
        assert_eq!(names, ["x/a.glb", "x/b.csv", "x/c.hdr"]);
    }

    fn with(fields: &str) -> Result<Scene, InputError> {
        Scene::from_ron(&SMALL.replace("count: 3", &format!("count: 3, {fields}")), "s.ron")
    }

    #[test]
    fn a_small_scene_has_every_default() {
        let scene = Scene::from_ron(SMALL, "s.ron").unwrap();
        assert_eq!((scene.size, scene.fps, scene.frames), ((1280, 720), 30.0, (0, 299)));
        assert_eq!(scene.trees[0].variants, 2);
        assert_eq!((scene.strategy, scene.culling), (Strategy::Compute, Culling::Sphere));
        assert_eq!(scene.elimination, Elimination::Scheduled);
        assert_eq!((scene.elimination_per_frame, scene.quality), (20, QualityPreset::High));
        assert_eq!(scene.prune_order, PruneOrder::BlueNoise);
        assert_eq!(scene.detail, Simplification::DEFAULT);
        let Reduction::Distance { d0 } = scene.shadow_detail.reduction else { panic!("{scene:?}") };
        assert_eq!(d0, 15.0);
    }

    #[test]
    fn choices_are_read_and_written_by_the_names_that_files_have() {
        let both = |field: &str, is: &dyn Fn(&Scene) -> bool| {
            let scene = with(field).unwrap();
            assert!(is(&scene), "{field}: {scene:?}");
            let written = scene.to_ron();
            assert!(written.contains(field), "{field}: {written}");
        };
        for (field, strategy) in [
            (r#"strategy: "vertex""#, Strategy::Vertex),
            (r#"strategy: "fragment""#, Strategy::Fragment),
            (r#"strategy: "vertex-buffer""#, Strategy::VertexBuffer),
            (r#"strategy: "compute""#, Strategy::Compute),
        ] {
            both(field, &|scene| scene.strategy == strategy);
        }
        for (field, order) in [
            (r#"prune_order: "random""#, PruneOrder::Random),
            (r#"prune_order: "importance""#, PruneOrder::Importance),
            (r#"prune_order: "blue-noise""#, PruneOrder::BlueNoise),
        ] {
            both(field, &|scene| scene.prune_order == order);
        }
        for (field, elimination) in [
            (r#"elimination: "off""#, Elimination::Off),
            (r#"elimination: "progressive""#, Elimination::Progressive),
            (r#"elimination: "scheduled""#, Elimination::Scheduled),
        ] {
            both(field, &|scene| scene.elimination == elimination);
        }
        for (field, culling) in [
            (r#"culling: "off""#, Culling::Off),
            (r#"culling: "clip-space""#, Culling::ClipSpace),
            (r#"culling: "sphere""#, Culling::Sphere),
            (r#"culling: "occlusion""#, Culling::Occlusion),
        ] {
            both(field, &|scene| scene.culling == culling);
        }
        for (field, quality) in [
            (r#"quality: "low""#, QualityPreset::Low),
            (r#"quality: "medium""#, QualityPreset::Medium),
            (r#"quality: "high""#, QualityPreset::High),
        ] {
            both(field, &|scene| scene.quality == quality);
        }
    }

    #[test]
    fn an_unknown_name_is_refused_where_it_stands() {
        // The column is that of the name's first letter.
        for (field, message) in [
            (
                r#"    strategy: "gpu""#,
                "line 2, column 16: strategy \"gpu\" is not known; \
                 there are: vertex, fragment, vertex-buffer, cpu, compute",
            ),
            (
                r#"prune_order: "pink""#,
                "line 2, column 15: prune order \"pink\" is not known; \
                 there are: random, importance, blue-noise",
            ),
            (
                r#"elimination: "Off""#,
                "line 2, column 15: elimination \"Off\" is not known; \
                 there are: off, progressive, scheduled",
            ),
            (
                r#"culling: "spheres""#,
                "line 2, column 11: culling \"spheres\" is not known; \
                 there are: off, clip-space, sphere, occlusion",
            ),
            (
                r#"quality: """#,
                "line 2, column 11: quality \"\" is not known; there are: low, medium, high",
            ),
            // Names are strings, as they always were.
            ("quality: low", "line 2, column 9: Expected string"),
        ] {
            let error = with(&format!("\n{field}")).unwrap_err();
            assert_eq!(error.to_string(), format!("s.ron: {message}"));
            assert_eq!(error.kind, InputErrorKind::Malformed);
        }
    }

    /// Each of these steps is lost in `f32`.
    #[test]
    fn places_and_moments_are_exact_far_away_and_late() {
        let scene = with(
            "time: 864000.001, events: [(tree: 0, leaf: 1, time: 864000.002)], \
             keep_out: [(from: (99999.0001, 0), to: (0, -99999.0002), radius: 1)]",
        );
        let scene = scene.unwrap();
        assert_eq!((scene.time, scene.events[0].time), (864_000.001, 864_000.002));
        let strip = scene.keep_out[0];
        assert_eq!((strip.from, strip.to), ((99_999.000_1, 0.0), (0.0, -99_999.000_2)));
        let camera = "camera: [\
            (time: 864000.001, eye: (99999.0003, 1, 0), target: (0, 0, 99999.0004)), \
            (time: 864000.002, eye: (1, 1, 1), target: (0, 0, 0))]";
        let text = SMALL.replace("camera: [(eye: (0, 1.7, 20), target: (0, 5, 0))]", camera);
        let [first, second] = Scene::from_ron(&text, "s.ron").unwrap().camera[..] else { panic!() };
        assert_eq!((first.time, second.time), (864_000.001, 864_000.002));
        assert_eq!((first.eye.0, first.target.2), (99_999.000_3, 99_999.000_4));
    }

    #[test]
    fn faults_are_named_with_their_place() {
        let cases = [
            ("count: 3", "count: 3, clouds: 4", "s.ron: line 1, column"),
            ("count: 3", "count: 3, clouds: 4", "clouds"),
            ("version: 1", "version: 7", "s.ron: version: version 7 is not known"),
            ("count: 3", "count: 1000000", "s.ron: count: 1000000"),
            ("count: 3", "count: 3, size: (0, 5)", "s.ron: size: 0x5"),
            ("count: 3", "count: 3, fps: 0", "s.ron: fps: 0"),
            ("count: 3", "count: 3, time: 10000001", "s.ron: time: 10000001 is not within"),
            ("count: 3", "count: 3, loose_leaves: 4000001", "s.ron: loose_leaves: 4000001"),
            ("count: 3", "count: 3, elimination_per_frame: 0", "s.ron: elimination_per_frame: 0"),
            ("count: 3", "count: 3, detail: (h: 1)", "s.ron: detail.h: 1 is not within 0 to 0.99"),
            ("count: 3", "count: 3, shadow_detail: (h: NaN)", "s.ron: shadow_detail.h: NaN"),
            ("count: 3", "count: 3, detail: (fade: Sise)", "fade: Unexpected variant named `Sise`"),
            ("(0, 5, 0)", "(0, inf, 0)", "s.ron: camera[0].target: inf"),
            ("(0, 5, 0)", "(0, 5, 100001)", "s.ron: camera[0].target: 100001"),
            ("(0, 5, 0)", "(0, 1.7, 20)", "s.ron: camera[0]: eye and target are the same"),
            ("[(source: Species(\"oak\"))]", "[]", "s.ron: trees: no tree"),
            ("\"oak\"", "\"oakk\"", "s.ron: trees[0].source: no species is called \"oakk\""),
            ("count: 3", "count: 3, scale: (0, 1)", "s.ron: scale: (0.0, 1.0) is not"),
            (
                "count: 3",
                "count: 3, events: [(tree: 0, leaf: 1, time: 2), (tree: 0, leaf: 1, time: NaN)]",
                "s.ron: events[1].time: NaN",
            ),
            ("count: 3", "count: 3, events: [(tree: 0, time: 1)]", "leaf"),
            ("count: 3", "count: ", "s.ron: line"),
        ];
        for (from, to, message) in cases {
            let error = error(from, to);
            assert!(error.contains(message), "{to}: {error}");
        }
    }
}
