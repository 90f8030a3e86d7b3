//! Structs that Rust and WGSL share, written once.
//!
//! [`gpu_struct!`] makes the Rust struct and the WGSL text from the same fields, and refuses to
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
            use $crate::shared::WgslType;
            $(assert!(
                std::mem::offset_of!($name, $field) % <$ty as WgslType>::ALIGN == 0,
                concat!(stringify!($name), ".", stringify!($field), " is misaligned for WGSL"),
            );)*
            let aligns = [$(<$ty as WgslType>::ALIGN),*];
            let mut largest = 1;
            let mut i = 0;
            while i < aligns.len() {
                if aligns[i] > largest {
                    largest = aligns[i];
                }
                i += 1;
            }
            assert!(
                std::mem::size_of::<$name>() % largest == 0,
                concat!(stringify!($name), " needs padding at its end for WGSL"),
            );
        };

        impl $name {
            /// The WGSL declaration of this struct.
            pub fn wgsl() -> String {
                let fields: Vec<String> = vec![$(format!(
                    "    {}: {},\n",
                    stringify!($field),
                    <$ty as $crate::shared::WgslType>::name(),
                )),*];
                format!("struct {} {{\n{}}}\n", stringify!($name), fields.concat())
            }
        }
    };
}

gpu_struct! {
    /// What every pass knows of the frame.
    pub struct Frame {
        /// Reversed-Z projection with the far plane at infinity, times the view.
        pub clip_from_world: Mat4,
        /// Its inverse.
        pub world_from_clip: Mat4,
        /// The camera, metres.
        pub eye: Vec3,
        /// Seconds since the scene began.
        pub time: f32,
        /// Unit vector towards the sun.
        pub sun_direction: Vec3,
        /// Season's phase, 0 late summer to 1 bare.
        pub season: f32,
        /// Irradiance of the sun on a surface that faces it.
        pub sun_color: Vec3,
        /// Extinction of the air, 1/m.
        pub haze: f32,
        /// Radiance of the sky at the zenith.
        pub sky_zenith: Vec3,
        /// Factor on radiance before tone mapping.
        pub exposure: f32,
        /// Radiance of the sky at the horizon.
        pub sky_horizon: Vec3,
        /// Pixels in a row.
        pub width: f32,
        /// Radiance that the ground sends upwards.
        pub ground_bounce: Vec3,
        /// Rows.
        pub height: f32,
    }
}

gpu_struct! {
    /// What the leaves of one tree model have in common.
    pub struct Model {
        /// Linear colours through autumn at equal steps; `w` is unused.
        pub palette: [Vec4; 8],
        /// Centre of the crown, metres.
        pub crown_center: Vec3,
        /// Colours in `palette`; 0 keeps the material's own.
        pub palette_count: u32,
        /// Half extents of the crown, metres.
        pub crown_extent: Vec3,
        /// Spread of the season's phase over the leaves of a tree.
        pub palette_spread: f32,
        /// Mean luminance of the leaf textures, to recolour them.
        pub texture_luminance: f32,
        /// Leaves of the model.
        pub leaf_count: u32,
        /// Height of the tree, metres.
        pub tree_height: f32,
        /// Unused.
        pub padding: u32,
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
        /// 1 where texels are holes, 0 where every texel is drawn. Alpha is rescaled so that the
        /// cut-off is one half.
        pub masked: u32,
        /// Unused.
        pub padding: Vec2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_name_every_field_in_order() {
        let text = Surface::wgsl();
        let places: Vec<usize> = ["base_color: vec3<f32>", "layer: i32", "padding: vec2<f32>"]
            .iter()
            .map(|field| text.find(field).unwrap())
            .collect();
        assert!(places.is_sorted());
        assert_eq!(Model::wgsl().matches("array<vec4<f32>, 8>").count(), 1);
    }
}
