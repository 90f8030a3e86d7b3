//! Numbers that Rust and WGSL both know, each written once: the text of every module begins with them.

use crate::base::names::UnknownName;
use crate::base::noise;
use windfall_core::light::SkyTable;
use windfall_core::wind::Wind;

macro_rules! shared_numbers {
    ($($(#[$meta:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: u32 = $value;)*

        /// Their WGSL.
        pub fn numbers() -> String {
            let mut text = String::new();
            $(text += &format!("const {}: u32 = {}u;\n", stringify!($name), $name);)*
            text + &format!(
                "const OCTAVE: f32 = {OCTAVE:?};\nconst SKY_SIDE: f32 = {:?};\n\
                 const NOISE_CELLS: f32 = {:?};\nconst NOISE_SIDE: f32 = {:?};\n\
                 const WIND_PERIOD: f32 = {:?};\n",
                SkyTable::SIDE as f32,
                noise::CELLS as f32,
                noise::SIDE as f32,
                Wind::PERIOD as f32,
            )
        }
    };
}

/// Bounds of parts of leaves in a factor of two.
pub const OCTAVE: f32 = 4.0;

shared_numbers! {
    /// Cascades of the sun's shadow maps.
    CASCADES = 3;
    /// What lists of trees are made for: the view, then the shadow maps.
    VIEWS = 1 + CASCADES;
    /// Kinds of lists of trees: for leaves of each form (`windfall_core::simplify::LeafForm`), then for wood.
    KINDS = 4;
    /// Lists of trees: those of a kind for each view, kind by kind.
    LISTS = KINDS * VIEWS;
    /// The kind of leaves in two triangles: what becomes of them reads the list of the view, the first of all.
    SIMPLE = 0;
    /// The kind of outlines that are lit at their vertices.
    OUTLINES = 1;
    /// The kind of outlines that are lit in each pixel.
    PIXELS = 2;
    /// The kind of wood.
    WOOD = 3;
    /// LOD bins of a list of trees: the highest is that of trees with all of their leaves.
    BUCKETS = 48;
    /// Trees of a block, and threads of most workgroups.
    BLOCK = 64;
    /// Most levels of wood.
    WOOD_LEVELS = 16;
    /// Words that count trees, behind the arguments of a list: two each for trees in view, their leaves,
    /// leaves by λ, leaves on twigs, triangles, trees that others hide and their leaves by λ.
    TREE_TALLIES = 14;
    /// Slots of a workgroup that poses their leaves.
    GROUP = 4 * BLOCK;
    /// Most groups of slots that a workgroup poses.
    MOST_TOGETHER = 8;
    /// How many groups of slots a forest has for each of those.
    TOGETHER_FROM = 512;
    /// Workgroups in a row of a dispatch.
    ROW = 32_768;
    /// Words of the forest's counters: see `windfall_gpu::scene::falls::Counter`.
    TALLIES = 12;
    /// Words of a view's counters before the arguments of its draws: leaves drawn in the air, leaves drawn on the
    /// ground, then groups of slots to gather from, workgroups in a row for them, rows.
    VIEW_TALLIES = 5;
    /// Words of an indirect draw.
    DRAW_WORDS = 5;
    /// Texels in a row of the path tables.
    TABLE_WIDTH = 1024;
    /// Vectors of a model in the path tables, before the colours of its palette.
    MODEL_HEAD = 3;
    /// Colours of a palette.
    PALETTE = 8;
    /// Vectors of a stream in the work on leaves.
    WINDOW = 5;
    /// Words of a leaf vertex.
    LEAF_VERTEX_WORDS = 10;
    /// Walls about the terrain on which a row of hills or trees is drawn.
    LAND_SIDES = 48;
    /// Quads of a draw: as many as indices of 16 bits reach.
    BATCH = 1 << 14;
}

const _: () = assert!(TABLE_WIDTH.is_power_of_two());

macro_rules! effects {
    ($($(#[$meta:meta])* $name:ident = $wgsl:ident;)*) => {
        /// What a frame is drawn with: bits of `Frame::effects`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Effect {
            $($(#[$meta])* $name,)*
        }

        /// Their WGSL.
        pub fn effects() -> String {
            let mut text = String::new();
            $(text += &format!(
                "const {}: u32 = {}u;\n", stringify!($wgsl), Effect::$name.bit(true)
            );)*
            text
        }
    };
}

effects! {
    /// The sky is the host's picture.
    SkyPicture = SKY_PICTURE;
    /// Shadows soften with the distance of what casts them.
    SoftShadows = SOFT_SHADOWS;
    /// Near leaves have veins.
    Veins = VEINS;
    /// Bark has relief.
    BarkRelief = BARK_RELIEF;
    /// Woods and hills stand beyond the terrain.
    Backdrop = BACKDROP;
    /// Leaves are glossy.
    Gloss = GLOSS;
    /// Light shines through leaves.
    Transmission = TRANSMISSION;
    /// Leaves deep in a crown are darker.
    AmbientOcclusion = AMBIENT_OCCLUSION;
    /// Pixels are filtered from samples of their neighbours too.
    ResolveFilter = RESOLVE_FILTER;
    /// The picture is clear where the sky would be.
    TransparentSky = TRANSPARENT_SKY;
}

impl Effect {
    /// Its bit where it is on.
    pub const fn bit(self, on: bool) -> u32 {
        (on as u32) << self as u32
    }
}

macro_rules! debug_views {
    ($($(#[$meta:meta])* $name:ident = $word:literal, $wgsl:ident;)*) => {
        /// What colours mean.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        pub enum DebugView {
            $($(#[$meta])* $name,)*
        }

        impl DebugView {
            /// Each of them.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its name on command lines.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $word,)*
                }
            }
        }

        /// Their WGSL.
        pub fn debug_views() -> String {
            let mut text = String::new();
            $(text += &format!(
                "const {}: u32 = {}u;\n", stringify!($wgsl), DebugView::$name as u32
            );)*
            text
        }
    };
}

debug_views! {
    /// The picture.
    #[default]
    Final = "picture", SHOW_FINAL;
    /// Leaves in the air by the loop of their path, those that lie in pink (VB Figure 5).
    Loops = "laps", SHOW_LOOPS;
    /// How far trees are simplified: red in full, through yellow and green to blue at λ = 1/256.
    Detail = "detail", SHOW_DETAIL;
    /// Leaves alone, on black.
    Leaves = "leaves", SHOW_LEAVES;
    /// What leaves cover: white on black, neither lit nor tone mapped.
    Coverage = "coverage", SHOW_COVERAGE;
    /// What leaf occlusion does with leaves in the air, by a layer that has it (`windfall-papers`): those that
    /// are drawn in green, those that are tested in blue, those that are skipped in red, before everything.
    Occlusion = "occlusion", SHOW_OCCLUSION;
    /// The radiance of leaves alone, on black, times the exposure: linear up to 1, not tone mapped.
    Radiance = "radiance", SHOW_RADIANCE;
    /// Which leaf is seen, each in a colour of its own, on black. Before tone mapping a sample is a number in the
    /// digits of base 2,048, lowest first: the leaf in the model's order, counted from 1 (red, green), and the
    /// tree's index in the forest (blue, alpha); halves hold them exactly. Layers draw what they draw.
    Ids = "ids", SHOW_IDS;
    /// Leaves and wood as they were read: leaves green, wood brown, darker where they are seen at a slant; on black,
    /// neither lit nor tone mapped.
    Parts = "parts", SHOW_PARTS;
    /// Normals of leaves and wood on the side that is seen, in the forest's frame: `0.5 + 0.5 n` in the picture's
    /// encoded values; on black, neither lit nor tone mapped.
    Normals = "normals", SHOW_NORMALS;
}

impl DebugView {
    /// Whether nothing but leaves is drawn.
    pub fn leaves_alone(self) -> bool {
        matches!(self, Self::Leaves | Self::Coverage | Self::Radiance | Self::Ids)
    }

    /// Whether nothing but leaves and wood is drawn.
    pub fn trees_alone(self) -> bool {
        self.leaves_alone() || matches!(self, Self::Parts | Self::Normals)
    }
}

impl std::fmt::Display for DebugView {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for DebugView {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let known: Vec<&str> = Self::ALL.iter().map(|v| v.name()).collect();
        Self::ALL
            .iter()
            .copied()
            .find(|v| v.name() == name)
            .ok_or_else(|| UnknownName::new("view", name, &known))
    }
}
