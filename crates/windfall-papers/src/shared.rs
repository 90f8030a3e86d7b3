//! Structs that Rust and the strategies' WGSL share.

use glam::{Vec3, Vec4};
use windfall_gpu::gpu_struct;

gpu_struct! {
    /// A leaf that has left its twig, as the strategies without compute take it: five vectors of an
    /// instance-step vertex buffer, or five texels.
    pub struct FallingLeaf {
        /// Centre on the twig, in the world, metres.
        pub origin: Vec3,
        /// When it detaches, seconds since the scene began.
        pub detach_time: f32,
        /// Where it lands, and seconds after the detachment.
        pub landing: Vec4,
        /// Seconds by which gusts come late at its tree.
        pub late: f32,
        /// Index of the tree model.
        pub model: f32,
        /// When another leaf takes its place, seconds since the scene began.
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
        /// Bytes from the lowest: material, ambient light on the twig (unorm), bent normal in the
        /// world in octahedral coordinates (two snorm).
        pub look: u32,
        /// `windfall_core::path::Variant`, as one number.
        pub variant: u32,
        /// Factor on the shape, and height over the ground at which it lies, metres, as f16.
        pub scale_stack: u32,
    }
}

gpu_struct! {
    /// A leaf that lies for good: an instance-step vertex buffer.
    pub struct LitterLeaf {
        /// Centre in the world, metres.
        pub position: Vec3,
        /// Factor on the shape.
        pub scale: f32,
        /// As [`LooseLeaf`].
        pub orientation_xy: u32,
        /// As [`LooseLeaf`].
        pub orientation_zw: u32,
        /// As [`LooseLeaf`], before it withers.
        pub color: u32,
        /// As [`LooseLeaf`].
        pub look: u32,
        /// When it landed, seconds since the scene began.
        pub landed_time: f32,
        /// When another leaf takes its place, seconds since the scene began.
        pub vanish_time: f32,
        /// Unused.
        pub padding0: u32,
        /// Unused.
        pub padding1: u32,
    }
}

