//! Stages, cameras and light as measurements need them.

use glam::Mat4;
use windfall_core::forest::{Forest, Instance, Terrain};
use windfall_core::tree::Tree;
use windfall_gpu::{Camera, Falls, Light, Projection, Sky, View};
use windfall_scenes::{Elimination, LandingSearch, Stage, Strategy};

/// A stage in the middle of autumn, whose falling leaves are posed in a compute shader.
pub fn stage(trees: Vec<Tree>, forest: Forest, falls: Falls) -> Stage {
    Stage {
        trees,
        forest,
        falls,
        season: 0.55,
        strategy: Strategy::Compute,
        elimination: Elimination::default(),
        elimination_per_frame: 0,
        leaf_occlusion: None,
        landing_search: LandingSearch::default(),
        events: Vec::new(),
    }
}

/// One tree on level ground.
pub fn single_tree(tree: Tree) -> Stage {
    let instance = Instance::alone(0, 1);
    let forest = Forest { terrain: Terrain::flat(), instances: vec![instance] };
    stage(vec![tree], forest, Falls::none())
}

/// Clip space from the world, for a picture `aspect` times as wide as high. Single precision: the
/// camera is near the origin.
pub fn clip_from_world(camera: &Camera, aspect: f32) -> Mat4 {
    let projection = match camera.projection {
        Projection::Perspective { fov_y, near } => {
            Mat4::perspective_infinite_reverse_rh(fov_y, aspect, near)
        }
        Projection::Matrix(matrix) => matrix,
    };
    let view = Mat4::from_quat(camera.rotation.conjugate());
    projection * view * Mat4::from_translation(-camera.eye.as_vec3())
}

/// Pixels that 1 m covers at a distance of 1 m, in a picture of `height` rows.
pub fn pixels(camera: &Camera, height: u32) -> f32 {
    // The vertical scale does not depend on the aspect.
    let projection = match camera.projection {
        Projection::Perspective { fov_y, near } => {
            Mat4::perspective_infinite_reverse_rh(fov_y, 1.0, near)
        }
        Projection::Matrix(matrix) => matrix,
    };
    0.5 * height as f32 * projection.y_axis.y
}

/// Changes the sky of a view; the views of measurements are lit by Windfall's own.
pub fn edit_sky(view: &mut View, edit: impl FnOnce(&mut Sky)) {
    if let Light::Sky(sky, _) = &mut view.light {
        edit(sky);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    /// A field of view of a right angle: what is as far aside as ahead is at the edge.
    #[test]
    fn what_is_at_the_edge_of_the_field_of_view_is_at_the_edge_of_the_picture() {
        let right_angle = std::f32::consts::FRAC_PI_2;
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let camera = Camera::look_at(eye, eye - DVec3::Z, right_angle, 0.1);
        let corner = clip_from_world(&camera, 2.0).project_point3(Vec3::new(9.0, 6.0, -1.0));
        assert!(corner.truncate().abs_diff_eq(glam::Vec2::ONE, 1e-5), "{corner}");
        // A metre at a metre is half of the picture.
        assert!((pixels(&camera, 100) - 50.0).abs() < 1e-4);
    }
}
