//! What a camera can see.

use glam::{Mat4, Vec3, Vec4};

/// The planes of a view, with normals that look inwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    planes: [Vec4; 5],
}

impl Frustum {
    /// The view of a reversed-Z projection whose far plane is at infinity (Gribb & Hartmann 2001).
    pub fn new(clip_from_world: Mat4) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| clip_from_world.row(i));
        // Depth 1 is near: z <= w. Nothing is too far.
        let planes = [w + x, w - x, w + y, w - y, w - z];
        Self { planes: planes.map(|p| p / p.truncate().length().max(f32::MIN_POSITIVE)) }
    }

    /// The planes; a point is inside where `normal · point + w` is not below 0 for all of them.
    pub fn planes(&self) -> [Vec4; 5] {
        self.planes
    }

    /// Whether any of a sphere may be in view; never wrong when it says no.
    pub fn sees_sphere(&self, center: Vec3, radius: f32) -> bool {
        self.planes.iter().all(|plane| plane.dot(center.extend(1.0)) >= -radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_seen_exactly_where_they_touch_the_view() {
        // From the origin towards -Z, 90 degrees: the right-hand plane is x = -z.
        let view = Mat4::look_to_rh(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y);
        let clip =
            Mat4::perspective_infinite_reverse_rh(std::f32::consts::FRAC_PI_2, 1.0, 0.1) * view;
        let frustum = Frustum::new(clip);
        assert!(frustum.sees_sphere(Vec3::new(0.0, 0.0, -1e6), 1.0));
        let behind = Vec3::new(0.0, 0.0, 5.0); // 5.1 behind the near plane
        assert!(!frustum.sees_sphere(behind, 5.0));
        assert!(frustum.sees_sphere(behind, 5.2));
        let beside = Vec3::new(20.0, 0.0, -10.0); // 10/√2 outside
        assert!(!frustum.sees_sphere(beside, 7.0));
        assert!(frustum.sees_sphere(beside, 7.2));
    }
}
