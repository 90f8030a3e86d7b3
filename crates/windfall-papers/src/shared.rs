//! Structs that Rust and the strategies' WGSL share.

use glam::{Vec3, Vec4};
use windfall_gpu::gpu_struct;

gpu_struct! {
    /// An active leaf: five vectors of an instance-step vertex buffer, or five texels. Times are on the clock of
    /// `FallFrame::time`.
    pub struct FallingLeaf {
        /// Centre on the twig, in the world, metres.
        pub origin: Vec3,
        /// When it detaches, seconds.
        pub detach_time: f32,
        /// Where it lands, metres, and seconds from the detachment to the landing.
        pub landing: Vec4,
        /// Seconds by which gusts come late at its tree.
        pub late: f32,
        /// Index of the tree model.
        pub model: f32,
        /// When another leaf takes its slot, seconds.
        pub vanish_time: f32,
        /// How far it is ahead of the season.
        pub ripe: f32,
        /// Orientation on the twig, x and y as snorm16.
        pub twig_xy: u32,
        /// Orientation on the twig, z and w as snorm16.
        pub twig_zw: u32,
        /// Orientation on the ground, x and y as snorm16.
        pub lying_xy: u32,
        /// Orientation on the ground, z and w as snorm16.
        pub lying_zw: u32,
        /// Hash of tree and shed rank.
        pub seed: u32,
        /// Bytes from the lowest: material, ambient occlusion on the twig (unorm), bent normal in the world in
        /// octahedral coordinates (two snorm).
        pub look: u32,
        /// `windfall_core::path::Variant::word`.
        pub variant: u32,
        /// Factor on the shape, and height over the ground at which it lies, metres, as f16.
        pub scale_stack: u32,
    }
}

gpu_struct! {
    /// A leaf of the litter: an instance-step vertex buffer. Encoded as `windfall_gpu`'s `LooseLeaf`.
    pub struct LitterLeaf {
        /// Centre in the world, metres.
        pub position: Vec3,
        /// Factor on the shape.
        pub scale: f32,
        /// Orientation, x and y as snorm16.
        pub orientation_xy: u32,
        /// Orientation, z and w as snorm16.
        pub orientation_zw: u32,
        /// Colour before it withers, and ambient occlusion.
        pub color: u32,
        /// Packed appearance.
        pub look: u32,
        /// When it landed, seconds on the clock of `FallFrame::time`.
        pub landed_time: f32,
        /// When another leaf takes its slot, seconds on the same clock.
        pub vanish_time: f32,
        /// Unused.
        pub padding0: u32,
        /// Unused.
        pub padding1: u32,
    }
}
