//! Structs that Rust and WGSL share, written once.
//!
//! `gpu_struct!` makes the Rust struct and the WGSL text from the same fields, and refuses to
//! compile where Rust's layout is not WGSL's: the two cannot drift apart.

use glam::{Mat4, UVec4, Vec2, Vec3, Vec4};

/// A type that has a counterpart in WGSL.
pub trait WgslType {
    /// Alignment in WGSL's host-shareable address spaces, bytes.
    const ALIGN: usize;
    /// Its WGSL name.
    fn name() -> String;
}

macro_rules! wgsl_types {
    ($($rust:ty => $name:literal, $align:literal;)*) => {
        $(impl WgslType for $rust {
            const ALIGN: usize = $align;
            fn name() -> String {
                $name.to_owned()
            }
        })*
    };
}

wgsl_types! {
    f32 => "f32", 4;
    u32 => "u32", 4;
    i32 => "i32", 4;
    Vec2 => "vec2<f32>", 8;
    Vec3 => "vec3<f32>", 16;
    Vec4 => "vec4<f32>", 16;
    UVec4 => "vec4<u32>", 16;
    Mat4 => "mat4x4<f32>", 16;
}

impl<T: WgslType, const N: usize> WgslType for [T; N] {
    const ALIGN: usize = T::ALIGN;
    fn name() -> String {
        format!("array<{}, {N}>", T::name())
    }
}

/// Declares a struct for both languages.
///
/// `Name::wgsl()` gives its WGSL declaration. A field that would sit at another offset in WGSL than
/// in Rust is a compile error; so are padding bytes (through `bytemuck::Pod`).
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $ty:ty,)*
    }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        $vis struct $name {
            $($(#[$field_meta])* $field_vis $field: $ty,)*
        }

        const _: () = {
            use $crate::internals::WgslType;
            $(assert!(
                std::mem::offset_of!($name, $field) % <$ty as WgslType>::ALIGN == 0,
                concat!(stringify!($name), ".", stringify!($field), " is misaligned for WGSL"),
            );)*
            assert!(
                std::mem::size_of::<$name>() % <$name as WgslType>::ALIGN == 0,
                concat!(stringify!($name), " needs padding at its end for WGSL"),
            );
        };

        impl $crate::internals::WgslType for $name {
            const ALIGN: usize = {
                let aligns = [$(<$ty as $crate::internals::WgslType>::ALIGN),*];
                let mut largest = 1;
                let mut i = 0;
                while i < aligns.len() {
                    if aligns[i] > largest {
                        largest = aligns[i];
                    }
                    i += 1;
                }
                largest
            };
            fn name() -> String {
                stringify!($name).to_owned()
            }
        }

        impl $name {
            /// The WGSL declaration of this struct.
            pub fn wgsl() -> String {
                let fields: Vec<String> = vec![$(format!(
                    "    {}: {},\n",
                    stringify!($field),
                    <$ty as $crate::internals::WgslType>::name(),
                )),*];
                format!("struct {} {{\n{}}}\n", stringify!($name), fields.concat())
            }
        }
    };
}

gpu_struct! {
    /// What every pass knows of the frame.
    pub struct Frame {
        /// Read by no shader. Where one branches on the frame and reads its first bytes, Mesa's lavapipe
        /// 22.3 compiles it anew each time it is bound, and keeps them all: it takes those bytes for what
        /// the branch is on and puts their value into the shader.
        pub unread: Vec4,
        /// Reversed-Z projection with the far plane at infinity, times the view.
        pub clip_from_world: Mat4,
        /// Its inverse.
        pub world_from_clip: Mat4,
        /// Clip space of the shadow maps, nearest cascade first.
        pub shadow_from_world: [Mat4; 3],
        /// Distances at which the cascades end, metres; `w` is 1 with shadows and 0 without.
        pub shadow_ends: Vec4,
        /// Sizes of the cascades' texels, metres; `w` is the share of a side that is in use.
        pub shadow_texels: Vec4,
        /// The camera, metres from the forest's origin.
        pub eye: Vec3,
        /// Clock of the gusts: seconds within `windfall_core::wind::Wind::PERIOD`.
        pub time: f32,
        /// Unit vector towards the sun.
        pub sun_direction: Vec3,
        /// Season's phase, 0 late summer to 1 bare.
        pub season: f32,
        /// Ambient light: `windfall_core::light::Ambient`. From here on [`SkyUniform`], which the sky's own
        /// pass may write.
        pub ambient: [Vec4; 9],
        /// Irradiance of the sun on a surface that faces it.
        pub sun_color: Vec3,
        /// Factor on the host's picture of the sky.
        pub sky_scale: f32,
        /// Gusts: amplitude along x and z, cycles in the wind's period, phase.
        pub gusts: [Vec4; 4],
        /// Steady wind along x and z, m/s.
        pub wind_mean: Vec2,
        /// Direction in which gusts travel.
        pub wind_travel: Vec2,
        /// Where the land beyond the terrain begins: height of the ground at the origin, its rise
        /// along x and z, distance from the origin.
        pub backdrop: Vec4,
        /// Trodden paths: two ends along x and z each.
        pub trails: [Vec4; 4],
        /// Half widths of the paths, metres; 0 is none.
        pub trail_widths: Vec4,
        /// Linear colour of leaves that have just fallen.
        pub litter: Vec3,
        /// Factor on radiance before tone mapping.
        pub exposure: f32,
        /// How far the clouds have drifted.
        pub cloud_drift: Vec2,
        /// Clip space z of a point from its w: factor and term, for perspective views.
        pub depth_from_w: Vec2,
        /// Seconds since the shedding began, as the sum of two numbers: rounded, and what that leaves out.
        pub shed_time: f32,
        /// See `shed_time`.
        pub shed_time_low: f32,
        /// Pixels in a row.
        pub width: f32,
        /// Rows.
        pub height: f32,
        /// Seconds per metre of the gusts.
        pub wind_slowness: f32,
        /// 1 where trees sway in the wind, 0 where they stand still.
        pub sway: f32,
        /// Extinction of the air, 1/m.
        pub haze: f32,
        /// Bits of `windfall_gpu::Quality`.
        pub effects: u32,
        /// Samples of a shadow map at a pixel of the ground.
        pub shadow_taps: u32,
        /// Share of the sky that thin clouds cover.
        pub clouds: f32,
        /// Added to how grassy the ground is.
        pub grassy: f32,
        /// What colours mean: `windfall_gpu::DebugView` as a number.
        pub show: u32,
        /// 1 where leaves fade by easing in and out.
        pub fade_smooth: u32,
        /// What draws together in simplified trees: 1 colours, 2 shading, 3 both.
        pub contrasts: u32,
        /// 1 where the view is orthographic.
        pub orthographic: u32,
        /// 1 where depth in the shadow maps is 1 nearest to the sun.
        pub shadow_reversed: u32,
        /// Pixels that a metre covers at a distance of one metre.
        pub pixels: f32,
        /// `Simplification::leaf_pixels`.
        pub leaf_pixels: f32,
        /// `Simplification::lit_leaf_pixels`.
        pub lit_leaf_pixels: f32,
        /// `Quality::resolution`.
        pub resolution: f32,
    }
}

gpu_struct! {
    /// The light of the sky, as it stands in [`Frame`].
    pub struct SkyUniform {
        /// As [`Frame::ambient`].
        pub ambient: [Vec4; 9],
        /// As [`Frame::sun_color`].
        pub sun_color: Vec3,
        /// As [`Frame::sky_scale`].
        pub sky_scale: f32,
    }
}
const _: () = assert!(
    std::mem::offset_of!(Frame, gusts) - std::mem::offset_of!(Frame, ambient)
        == size_of::<SkyUniform>(),
    "the sky's light is one piece of the frame"
);

gpu_struct! {
    /// A list of trees that is drawn: which belong to it, and how they are simplified. As
    /// `windfall_core::simplify::Simplification`.
    pub struct TreeList {
        /// Planes of the view or of the shadow map, normals inwards.
        pub planes: [Vec4; 5],
        /// Clip space of the view.
        pub clip_from_world: Mat4,
        /// Where distances are measured from, metres.
        pub eye: Vec3,
        /// Pixels that a metre covers at a distance of one metre.
        pub pixels: f32,
        /// `log_h 1/2`.
        pub exponent: f32,
        /// `d0²`, or `π/B0`.
        pub reduction: f32,
        /// Squares of pixels that are seen as one, a side; 0 for contrasts as SFS has them.
        pub contrast_pixels: f32,
        /// `FadeRange`: 0 constant, 1 linear, 2 quadratic, 3 proportional.
        pub range_kind: u32,
        /// Its constant.
        pub range: f32,
        /// `Growth::factor`, or -1 where leaves do not grow.
        pub growth_factor: f32,
        /// `Growth::pixels`.
        pub growth_pixels: f32,
        /// The sum of 1 where a tree in full has no faded leaves, 2 where leaves are gone at rank λ, 4 where
        /// the reduction is by projected area, 8 where large leaves are lit in each pixel.
        pub flags: u32,
        /// `Culling` as a number.
        pub culling: u32,
        /// `Simplification::wood_pixels`.
        pub wood_pixels: f32,
        /// `Simplification::leaf_pixels`.
        pub leaf_pixels: f32,
        /// `Simplification::mean_cosine`, or -1 for that of the trees' own leaves.
        pub mean_cosine: f32,
    }
}

gpu_struct! {
    /// A frame's lists of trees, and the sizes of the tables behind them. Of each of `lists` there is one of each
    /// kind.
    pub struct CullFrame {
        /// The view, then the shadow maps.
        pub lists: [TreeList; crate::base::constants::VIEWS as usize],
        /// Near plane of the view, metres.
        pub near: f32,
        /// Width of the picture, pixels.
        pub width: f32,
        /// Height of the picture, pixels.
        pub height: f32,
        /// Places of trees: those of a model begin at a multiple of 64.
        pub tree_count: u32,
        /// Tree models.
        pub model_count: u32,
        /// Draws of a list.
        pub draw_count: u32,
        /// Level of the occlusion pyramid that is one texel.
        pub top_level: u32,
        /// Bound of the wind's speed, m/s; 0 where trees stand still.
        pub wind_speed: f32,
        /// Distance from the camera within which a loose leaf may shade what is in view though it is not in
        /// view itself, metres; 0 without shadows.
        pub shadow_reach: f32,
        /// Unused.
        pub padding0: u32,
        /// Unused.
        pub padding1: u32,
        /// Unused.
        pub padding2: u32,
    }
}

gpu_struct! {
    /// What the trees of one model have in common when lists are made.
    pub struct Crown {
        /// Centre of the bounding sphere in the tree, metres.
        pub center: Vec3,
        /// Its radius, metres.
        pub radius: f32,
        /// Half the bounding box about the same centre, metres.
        pub half_size: Vec3,
        /// Mean length of a leaf, metres.
        pub leaf_length: f32,
        /// `windfall_core::simplify::Visibility::disocclusion`.
        pub disocclusion: Vec3,
        /// Leaves of the model.
        pub leaf_count: u32,
        /// `r`: the visible area of a leaf over that of the crown.
        pub visible_share: f32,
        /// `ln(1 - r)`.
        pub log_hidden: f32,
        /// First of the model's places, a multiple of 64.
        pub tree_first: u32,
        /// First of its draws in a list.
        pub draw_first: u32,
        /// Its draws: of outlines, of leaves in two triangles, of wood.
        pub draw_count: u32,
        /// Lengths of the shortest and of the longest leaf, metres, as half floats.
        pub leaf_lengths: u32,
        /// Groups of 64 places.
        pub block_count: u32,
        /// Levels of its wood, at most 16.
        pub wood_levels: u32,
        /// Their errors, metres, rising from 0.
        pub wood_errors: [Vec4; 4],
        /// `windfall_core::simplify::Shading::normals`: xx, yy, zz.
        pub normal_squares: Vec3,
        /// `windfall_core::foliage::Foliage::leaf_side`, metres.
        pub leaf_side: f32,
        /// Twice xy, yz, zx.
        pub normal_products: Vec3,
        /// `windfall_core::foliage::Holes`: `solid` and `piece` as half floats, the first in the lower bits.
        pub holes: u32,
    }
}

gpu_struct! {
    /// One tree of the forest.
    pub struct TreeRecord {
        /// Foot, metres.
        pub position: Vec3,
        /// Factor on the model's size.
        pub scale: f32,
        /// Cosine of the yaw.
        pub cos_yaw: f32,
        /// Sine of the yaw.
        pub sin_yaw: f32,
        /// Added to the season.
        pub season_offset: f32,
        /// Seconds by which the tree sheds late.
        pub delay: f32,
        /// Phase of the gusts at the tree, turns.
        pub gust_phase: f32,
        /// Key of the tree.
        pub seed: u32,
        /// Index of its model; `u32::MAX` for a place that holds none.
        pub model: u32,
        /// Twice its index in the forest; 1 more where a program has thrown leaves of it
        /// (`windfall_gpu::Forest::throw`).
        pub index_events: u32,
    }
}

gpu_struct! {
    /// What the leaves of one tree model have in common.
    pub struct Model {
        /// Linear colours through autumn at equal steps; `w` is unused.
        pub palette: [Vec4; 8],
        /// Mean colours of leaves whose own time is drawn from `palette_spread` about a phase, at equal
        /// steps of that phase from `-palette_spread` to `1 + palette_spread`.
        pub mean_palette: [Vec4; 8],
        /// Centre of the crown, metres.
        pub crown_center: Vec3,
        /// Colours in `palette`; 0 keeps the material's own.
        pub palette_count: u32,
        /// Half extents of the crown, metres.
        pub crown_extent: Vec3,
        /// Spread of the season's phase over the leaves of a tree.
        pub palette_spread: f32,
        /// `windfall_core::simplify::Shading::ambient`.
        pub ambient: Vec3,
        /// Mean luminance of the leaf textures, to recolour them.
        pub texture_luminance: f32,
        /// `windfall_core::simplify::Visibility::sunlight`.
        pub sunlight: Vec3,
        /// Leaves of the model.
        pub leaf_count: u32,
        /// What lists of its trees are made from.
        pub crown: Crown,
    }
}

gpu_struct! {
    /// A surface, for wood and leaves.
    pub struct Surface {
        /// Linear factor on the colour.
        pub base_color: Vec3,
        /// Layer of the texture array, or -1.
        pub layer: i32,
        /// Bark: linear colour of the ridges.
        pub ridge: Vec3,
        /// Bark: 0 none, 1 smooth, 2 furrowed, 3 plated, 4 papery.
        pub pattern: u32,
        /// Bark: linear colour of the grooves.
        pub groove: Vec3,
        /// Bark: size of the pattern, metres.
        pub scale: f32,
        /// Roughness, `0..=1`.
        pub roughness: f32,
        /// `windfall_core::foliage::Holes::piece` of the picture, at least 0.001; 0 where every texel is drawn.
        /// Alpha is rescaled so that the cut-off is one half.
        pub piece: f32,
        /// Unused.
        pub padding: Vec2,
    }
}

gpu_struct! {
    /// One tree as it is drawn: an instance-step vertex buffer.
    pub struct TreeInstance {
        /// Foot, metres.
        pub position: Vec3,
        /// Factor on the model's size.
        pub scale: f32,
        /// Cosine of the yaw.
        pub cos_yaw: f32,
        /// Sine of the yaw.
        pub sin_yaw: f32,
        /// Added to the season.
        pub season_offset: f32,
        /// Share of the leaves that is drawn.
        pub lambda: f32,
        /// Rank from which on no leaf is seen.
        pub fade_end: f32,
        /// One over the range of ranks over which leaves fade.
        pub fade_slope: f32,
        /// Factor on a leaf's length.
        pub growth: f32,
        /// What is left of the contrast of colours and shading.
        pub contrast: f32,
        /// Key of the tree.
        pub seed: u32,
        /// Leaves of shed rank below the lower 24 bits have left their twigs; above them 1 where a program has
        /// thrown leaves of the tree.
        pub detached: u32,
        /// Wind at the foot along x and z, m/s, as f16.
        pub wind: u32,
        /// `windfall_core::simplify::Shading::mean_cosines` of the sun, as f16.
        pub mean_cosines: u32,
    }
}

gpu_struct! {
    /// What all falls have in common: the CPU reference is `windfall_core::path::Fall` and `shed::Shedding`.
    pub struct FallFrame {
        /// Read by no shader, as [`Frame::unread`]: landings branch on what follows.
        pub unread: Vec4,
        /// Gusts: amplitude along x and z, cycles in the wind's period, phase when the shedding begins.
        pub gusts: [Vec4; 4],
        /// Steady wind along x and z, m/s.
        pub wind_mean: Vec2,
        /// Direction in which gusts travel.
        pub wind_travel: Vec2,
        /// Seconds per metre of the gusts.
        pub wind_slowness: f32,
        /// Bound of the wind's speed; 0 is calm.
        pub wind_fastest: f32,
        /// Time constant of a leaf in the wind, seconds.
        pub wind_response: f32,
        /// Seconds since the shedding began, as the sum of two numbers: rounded, and what that leaves out.
        pub time: f32,
        /// See `time`.
        pub time_low: f32,
        /// The same within the wind's period.
        pub clock: f32,
        /// `FallSettings`.
        pub soft_drop: f32,
        /// `FallSettings`.
        pub soft_time: f32,
        /// `FallSettings`.
        pub settle_time: f32,
        /// `FallSettings`.
        pub settle_turn: f32,
        /// Bounds of the horizontal scale.
        pub scale_low: f32,
        /// Bounds of the horizontal scale.
        pub scale_high: f32,
        /// Bounds of the playback rate.
        pub rate_low: f32,
        /// Bounds of the playback rate.
        pub rate_high: f32,
        /// 1 for `Variation::Paper` of 2008, 2 for that of 2007.
        pub paper_variation: u32,
        /// Samples along a side of the terrain.
        pub ground_side: u32,
        /// Metres between them.
        pub ground_cell: f32,
        /// Highest ground, metres.
        pub ground_highest: f32,
        /// Steepest slope.
        pub ground_steepest: f32,
        /// When the shedding begins, seconds on the clock of `time`: 0, or never.
        pub shed_start: f32,
        /// `Shedding`.
        pub shed_duration: f32,
        /// `Shedding`.
        pub shed_peak: f32,
        /// `Shedding`.
        pub shed_burst: f32,
        /// Gusts per second.
        pub gust_rate: f32,
        /// Streams of the forest.
        pub stream_count: u32,
        /// Slots of all streams.
        pub slot_count: u32,
        /// Draws: one for each model and shape.
        pub bin_count: u32,
        /// Workgroups that pose leaves.
        pub group_count: u32,
        /// Changes whenever every slot has to be filled anew.
        pub generation: u32,
        /// 1 where leaves are coloured by the loops of their path.
        pub color_loops: u32,
        /// Where the tables' sections begin, in vectors.
        pub flight_table: u32,
        /// Where the tables' sections begin, in vectors.
        pub low_table: u32,
        /// Where the tables' sections begin, in vectors.
        pub group_table: u32,
        /// Where the tables' sections begin, in vectors.
        pub ground_table: u32,
        /// Where the tables' sections begin, in vectors.
        pub model_table: u32,
        /// What displacements of samples are multiples of, metres.
        pub path_grain: f32,
    }
}

gpu_struct! {
    /// The leaves of one shape on one tree, in shed order, and the slots that hold those that have
    /// detached last.
    pub struct Stream {
        /// Foot of the tree, metres.
        pub position: Vec3,
        /// Factor on the model's size.
        pub scale: f32,
        /// Cosine of the yaw.
        pub cos_yaw: f32,
        /// Sine of the yaw.
        pub sin_yaw: f32,
        /// Added to the season.
        pub season_offset: f32,
        /// Key of the tree.
        pub seed: u32,
        /// Seconds by which the tree sheds late.
        pub delay: f32,
        /// Phase of the gusts at the tree, turns.
        pub gust_phase: f32,
        /// Leaves of the tree, of all shapes.
        pub leaf_count: u32,
        /// Index of the model.
        pub model: u32,
        /// First entry of the shed list.
        pub list_first: u32,
        /// Entries of the shed list.
        pub list_count: u32,
        /// First slot.
        pub slot_first: u32,
        /// Slots; the leaf of entry `j` is kept in slot `slot_first + j % keep`.
        pub keep: u32,
        /// Draw that the leaves belong to.
        pub bin: u32,
        /// Group of paths that they fall by.
        pub path_group: u32,
        /// First leaf record of the model.
        pub leaf_first: u32,
        /// First slot of the draw.
        pub bin_first: u32,
        /// Extent of the shape above and below its middle, metres at scale 1.
        pub thickness: f32,
        /// Radius of the shape, metres at scale 1.
        pub radius: f32,
        /// 1 where detach times stand behind the entries of the shed list, 0 where they follow from
        /// shed ranks.
        pub thrown: u32,
        /// 1 where the shape can be drawn in two triangles.
        pub simple: u32,
        /// First of its workgroups that pose leaves.
        pub group_first: u32,
        /// 1 where a program has thrown leaves of the tree: they are not of this stream.
        pub events: u32,
        /// Index of the tree in its forest.
        pub tree: u32,
        /// Unused.
        pub padding: u32,
    }
}

gpu_struct! {
    /// A leaf of a model.
    pub struct LeafRecord {
        /// Centre in the tree, metres.
        pub center: Vec3,
        /// Factor on the shape.
        pub scale: f32,
        /// Orientation in the tree, x and y as snorm16.
        pub orientation_xy: u32,
        /// Orientation in the tree, z and w as snorm16.
        pub orientation_zw: u32,
        /// Shed rank.
        pub rank: u32,
        /// Bytes from the lowest: material, ambient light (unorm), bent normal in octahedral
        /// coordinates (two snorm).
        pub look: u32,
    }
}

gpu_struct! {
    /// A leaf in the air or on the ground as it is drawn: an instance-step vertex buffer.
    pub struct LooseLeaf {
        /// Centre in the world, metres.
        pub position: Vec3,
        /// Factor on the shape; 0 of a leaf that is not there. As posed, its two lowest bits say where the leaf
        /// is: 0 it lets go of its twig, 1 in the air, 2 on the ground.
        pub scale: f32,
        /// Orientation in the world, x and y as snorm16.
        pub orientation_xy: u32,
        /// Orientation in the world, z and w as snorm16.
        pub orientation_zw: u32,
        /// Linear colour, and the ambient light that reaches the leaf, as unorm8.
        pub color: u32,
        /// Material, bent normal in octahedral coordinates, how far the normal is bent.
        pub look: u32,
    }
}
