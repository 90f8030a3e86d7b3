//! Cascaded shadow maps of the sun, with texels that stay in place when the camera moves.

use crate::base::constants::CASCADES as COUNT;
use crate::base::pipeline::{Depth, Target};
use crate::base::shared::Frame;
use crate::base::timing::PassTargets;
use crate::view::camera::Eye;
use glam::{Mat4, Vec3};
use windfall_core::simplify::{LIT_AT_VERTICES, Simplification};

/// Number of cascades.
pub const CASCADES: usize = COUNT as usize;
/// Format of the maps: depth is 0 nearest to the sun.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// What pipelines that draw into them have as their target.
pub const TARGET: Target = Target {
    color: None,
    blend: false,
    depth: Some(Depth {
        format: FORMAT,
        compare: wgpu::CompareFunction::LessEqual,
        write: true,
        unclipped: false,
    }),
    samples: 1,
};

/// Most texels along a side of a cascade.
const SIZE: u32 = 2048;
/// Where each cascade ends, metres from the camera.
const ENDS: [f32; CASCADES] = [14.0, 52.0, 220.0];
/// How far beyond a cascade's sphere, towards the sun, something may stand that shades it, metres.
const REACH: f32 = 120.0;

/// One cascade of a frame.
#[derive(Clone, Copy)]
pub struct Cascade {
    /// Clip space of the map: depth 0 nearest to the sun.
    pub clip_from_world: Mat4,
    /// Size of a texel, metres.
    pub texel: f32,
    /// Texels along a side: a map may use a corner of its texture.
    pub size: u32,
    /// The sphere that it holds.
    center: Vec3,
    radius: f32,
}

/// The shadow maps.
pub struct Shadows {
    /// All cascades, for sampling.
    pub view: wgpu::TextureView,
    /// Each cascade, for drawing.
    pub layers: [wgpu::TextureView; CASCADES],
}

impl Shadows {
    pub fn new(device: &wgpu::Device) -> Self {
        let texture = |size, layers| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("shadow maps"),
                size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let all = |texture: &wgpu::Texture| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
        };
        let maps = texture(SIZE, CASCADES as u32);
        let layers = std::array::from_fn(|i| {
            maps.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: i as u32,
                array_layer_count: Some(1),
                ..Default::default()
            })
        });
        Self { view: all(&maps), layers }
    }

    /// The pass that draws a cascade.
    pub fn pass(&self, cascade: usize) -> PassTargets<'_> {
        PassTargets {
            label: "shadows",
            color: None,
            depth: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.layers[cascade],
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
        }
    }
}

/// The cascades of a view, nearest first; they reach `margin` times as far about it as they have to.
pub fn cascades(eye: &Eye, sun: Vec3, shadow_size: u32, margin: f32) -> [Cascade; CASCADES] {
    let size = shadow_size.clamp(256, SIZE);
    let mut start = eye.near;
    ENDS.map(|end| {
        let cascade = cascade(eye, sun, (size, margin), start, end);
        start = end;
        cascade
    })
}

/// A square map around the sphere that holds the view between two distances. The sphere does not
/// change when the camera turns, and its centre moves in whole texels: shadows' edges stand still.
fn cascade(eye: &Eye, sun: Vec3, (size, margin): (u32, f32), start: f32, end: f32) -> Cascade {
    let corner = eye.tangents.length_squared();
    // Where the sphere's centre must be along the view to touch both ends' corners.
    let along = (0.5 * (start + end) * (1.0 + corner)).min(end);
    let held = (end * end * corner + (end - along) * (end - along)).sqrt().ceil();
    let radius = held * margin;
    let center = eye.position + eye.forward * along;

    let up = if sun.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let light_from_world = Mat4::look_to_rh(Vec3::ZERO, -sun, up);
    let texel = 2.0 * radius / size as f32;
    let at = light_from_world.transform_point3(center);
    let snapped = Vec3::new((at.x / texel).floor() * texel, (at.y / texel).floor() * texel, at.z);
    let projection = Mat4::orthographic_rh(
        snapped.x - radius,
        snapped.x + radius,
        snapped.y - radius,
        snapped.y + radius,
        -snapped.z - radius - REACH,
        -snapped.z + radius,
    );
    Cascade { clip_from_world: projection * light_from_world, texel, size, center, radius }
}

/// How trees are simplified in a cascade, 0 nearest to the camera. A leaf is a few texels long there, but for the
/// nearest: two triangles do where the picture may still show an outline.
pub fn detail_of(cascade: usize, detail: &Simplification) -> Simplification {
    let leaf_pixels = match (detail.leaf_pixels > 0.0, cascade) {
        (false, _) => 0.0,
        (true, 0) => detail.leaf_pixels * LIT_AT_VERTICES,
        (true, _) => f32::MAX,
    };
    Simplification { leaf_pixels, ..*detail }
}

impl Cascade {
    /// Whether another one's sphere lies within this one's.
    pub fn holds(&self, other: &Self) -> bool {
        // A texel that the map was moved by.
        self.center.distance(other.center) + other.radius + self.texel <= self.radius
    }

    /// The frame's uniforms with this cascade in the camera's place.
    pub fn frame(&self, frame: &Frame, detail: &Simplification) -> Frame {
        Frame {
            clip_from_world: self.clip_from_world,
            fade_smooth: u32::from(detail.fade.smooth),
            leaf_pixels: detail.leaf_pixels,
            lit_leaf_pixels: f32::MAX,
            ..*frame
        }
    }
}

/// Fills in what the shaders need to look shadows up.
pub fn describe(frame: &mut Frame, cascades: &[Cascade; CASCADES], on: bool) {
    frame.shadow_from_world = cascades.map(|c| c.clip_from_world);
    frame.shadow_ends = Vec3::from(ENDS).extend(f32::from(u8::from(on)));
    frame.shadow_texels =
        Vec3::from(cascades.map(|c| c.texel)).extend(cascades[0].size as f32 / SIZE as f32);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::camera::Camera;
    use crate::view::light::Sky;
    use glam::DVec3;
    use windfall_core::forest::Frustum;

    fn eye(eye: Vec3, target: Vec3) -> Eye {
        let camera = Camera::look_at(eye.as_dvec3(), target.as_dvec3(), 0.9, 0.1);
        camera.eye(DVec3::ZERO, (160, 100)).unwrap()
    }

    fn sun(elevation: f32) -> Vec3 {
        Sky { sun_elevation: elevation, ..Sky::default() }.sun_direction()
    }

    #[test]
    fn cascades_hold_the_view_up_to_their_ends_for_any_sun() {
        for elevation in [0.02, 0.6, std::f32::consts::FRAC_PI_2] {
            let eye = eye(Vec3::new(3.0, 1.7, 9.0), Vec3::new(40.0, 8.0, -20.0));
            let world_from_clip = eye.clip_from_world.inverse();
            let cascades = cascades(&eye, sun(elevation), SIZE, 1.0);
            let mut start = 0.1;
            for (cascade, end) in cascades.iter().zip(ENDS) {
                for distance in [start, end] {
                    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                        // Depth near/distance is that distance along the view.
                        let p = Vec3::new(x, y, eye.near / distance);
                        let corner = world_from_clip.project_point3(p);
                        let at = cascade.clip_from_world.project_point3(corner);
                        assert!(at.x.abs() < 1.001 && at.y.abs() < 1.001, "{elevation}: {at}");
                        assert!((0.0..=1.0).contains(&at.z), "{elevation}: {at}");
                    }
                }
                start = end;
            }
        }
    }

    #[test]
    fn texels_stay_in_place_when_the_camera_moves() {
        let texels = |at: Vec3| {
            let c = cascades(&eye(at, at + Vec3::NEG_Z), sun(0.6), SIZE, 1.0)[1];
            c.clip_from_world.project_point3(Vec3::new(1.0, 2.0, 3.0)) * (SIZE as f32 * 0.5)
        };
        let moved = texels(Vec3::new(0.37, 1.9, 5.0)) - texels(Vec3::new(0.0, 1.7, 5.2));
        assert!(moved.x.abs() > 0.5, "{moved}");
        for v in [moved.x, moved.y] {
            assert!((v - v.round()).abs() < 0.02, "{moved}");
        }
    }

    #[test]
    fn a_tree_towards_the_sun_shades_and_one_behind_does_not() {
        let eye = eye(Vec3::ZERO, Vec3::NEG_Z);
        // The planes of a map hold what casts into it: lists of trees use them as a view's.
        let casts = Frustum::new(cascades(&eye, sun(0.6), SIZE, 1.0)[0].clip_from_world);
        let sun = sun(0.6);
        let here = Vec3::new(0.0, 0.0, -5.0);
        assert!(casts.sees_sphere(here + sun * 60.0, 3.0));
        assert!(!casts.sees_sphere(here - sun * 60.0, 3.0));
        let aside = sun.cross(Vec3::Y).normalize_or_zero() * 80.0;
        assert!(!casts.sees_sphere(here + aside, 3.0));
    }
}
