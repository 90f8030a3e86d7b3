//! Cameras: Windfall's pinhole, or any projection of a host.

use glam::{DVec3, Mat4, Quat, Vec2, Vec3};

/// A camera in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: DVec3,
    /// Turn of the camera: it looks along its -Z, +Y is up in the picture, as in glTF.
    pub rotation: Quat,
    /// What it sees.
    pub projection: Projection,
}

/// From the camera's space to clip space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// A pinhole: depth is 1 at the near plane and falls to 0 at infinity.
    Perspective {
        /// Vertical field of view, radians, above 0 and below π.
        fov_y: f32,
        /// Nearest distance that is drawn, metres, above 0. There is no farthest.
        near: f32,
    },
    /// The host's own: perspective, off-centre, jittered or orthographic; depth as
    /// [`crate::Options::reversed_depth`] says.
    Matrix(Mat4),
}

/// What cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A picture of no pixels.
    #[error("a view of {width}x{height} pixels has nothing to draw")]
    Empty {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A picture larger than textures of the device.
    #[error("a view of {width}x{height} pixels is larger than the {most} of the device's textures")]
    TooWide {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// [`wgpu::Limits::max_texture_dimension_2d`].
        most: u32,
    },
    /// A number of the camera is not finite, or its matrix cannot be inverted.
    #[error("the camera's {what} is {value}")]
    Camera {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: String,
    },
    /// The host's shadow map has no cascade, or more than three.
    #[error("a shadow map of {cascades} cascades; from 1 to 3 can be used")]
    Cascades {
        /// Its cascades.
        cascades: usize,
    },
    /// The view was made for another forest.
    #[error("the view state was made for another forest")]
    OtherForest,
    /// The view's buffers do not fit on the device.
    #[error("the view needs a buffer of {bytes} bytes, the device binds {most}")]
    TooLarge {
        /// Bytes of the buffer.
        bytes: u64,
        /// [`wgpu::Limits::max_storage_buffer_binding_size`].
        most: u64,
    },
    /// The renderer has not what the view needs.
    #[error("the renderer was made without {layer}")]
    NoLayer {
        /// What it lacks.
        layer: &'static str,
    },
    /// The forest has not been advanced to a moment yet.
    #[error("the forest was not advanced to a moment before it was drawn")]
    NotAdvanced,
    /// The forest has been made anew, for trees that it had no room for, since the view was prepared.
    #[error("the forest has grown since the view was prepared")]
    NotPrepared,
}

/// A camera as passes have it: relative to a forest's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    pub clip_from_world: Mat4,
    /// The eye; of an orthographic view a point far behind it.
    pub position: Vec3,
    pub forward: Vec3,
    /// Pixels that a metre covers at a distance of one metre from `position`.
    pub pixels: f32,
    pub orthographic: bool,
    pub depth_from_w: Vec2,
    /// Near plane of a pinhole with the far plane at infinity; 0 of an orthographic view.
    pub near: f32,
    /// Half of the view's angles as tangents: along, up.
    pub tangents: Vec2,
    /// Distance that stands for one of `position` where detail follows from distances.
    pub distance_scale: f32,
    pub width: u32,
    pub height: u32,
}

/// How far behind an orthographic view its eye is taken to be, metres.
const FAR_EYE: f32 = 10_000.0;

impl Camera {
    /// Pixels that a metre covers at a distance of one metre by a camera that people have: 1080 rows, 50°. An
    /// orthographic view has the detail of such a camera as far away as to see as much.
    pub const USUAL_PIXELS: f32 = 1158.0;

    /// A pinhole camera that stands at `eye` and looks at `target`, with the horizon level.
    pub fn look_at(eye: DVec3, target: DVec3, fov_y: f32, near: f32) -> Self {
        let forward = (target - eye).as_vec3().normalize_or(Vec3::NEG_Z);
        // Straight up or down, "up" is no guide: take north.
        let up = if forward.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y };
        let view = Mat4::look_to_rh(Vec3::ZERO, forward, up);
        let rotation = Quat::from_mat4(&view).conjugate();
        Self { eye, rotation, projection: Projection::Perspective { fov_y, near } }
    }

    /// Unit vector along which it looks.
    pub fn forward(&self) -> Vec3 {
        self.rotation * Vec3::NEG_Z
    }

    /// The camera for a picture of so many pixels, relative to an origin.
    pub(crate) fn eye(&self, origin: DVec3, (width, height): (u32, u32)) -> Result<Eye, ViewError> {
        if width == 0 || height == 0 {
            return Err(ViewError::Empty { width, height });
        }
        let bad = |what, value: String| Err(ViewError::Camera { what, value });
        let local = (self.eye - origin).as_vec3();
        if !local.is_finite() {
            return bad("eye", self.eye.to_string());
        }
        if !self.rotation.is_finite() || (self.rotation.length() - 1.0).abs() > 1e-3 {
            return bad("rotation", self.rotation.to_string());
        }
        let view_from_world =
            Mat4::from_quat(self.rotation.conjugate()) * Mat4::from_translation(-local);
        let aspect = width as f32 / height as f32;
        let projection = match self.projection {
            Projection::Perspective { fov_y, near } => {
                if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
                    return bad("fov_y", fov_y.to_string());
                }
                if !(near > 0.0 && near.is_finite()) {
                    return bad("near", near.to_string());
                }
                Mat4::perspective_infinite_reverse_rh(fov_y, aspect, near)
            }
            Projection::Matrix(matrix) => matrix,
        };
        let determinant = projection.determinant();
        if !projection.is_finite() || !determinant.is_finite() || determinant == 0.0 {
            return bad("projection", projection.to_string());
        }
        let orthographic = projection.row(3).truncate() == Vec3::ZERO;
        let forward = self.forward();
        // Rows: what a metre at one metre (or, of an orthographic view, anywhere) takes of the picture.
        let pixels = 0.5 * height as f32 * projection.y_axis.y.abs();
        let eye = Eye {
            clip_from_world: projection * view_from_world,
            position: local,
            forward,
            pixels,
            orthographic,
            // Along the view w is the distance: z = -w in the camera's space.
            depth_from_w: Vec2::new(-projection.z_axis.z, projection.w_axis.z),
            near: if orthographic { 0.0 } else { projection.w_axis.z },
            // The farther of both sides, where the view is off-centre.
            tangents: Vec2::new(
                (1.0 + projection.z_axis.x.abs()) / projection.x_axis.x.abs(),
                (1.0 + projection.z_axis.y.abs()) / projection.y_axis.y.abs(),
            ),
            distance_scale: 1.0,
            width,
            height,
        };
        if !orthographic {
            return Ok(eye);
        }
        Ok(Eye {
            position: local - forward * FAR_EYE,
            pixels: pixels * FAR_EYE,
            // As far away as a usual camera would be to see as much.
            distance_scale: Self::USUAL_PIXELS / pixels / FAR_EYE,
            ..eye
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    #[test]
    fn a_camera_looks_where_it_is_told() {
        let camera =
            Camera::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 2.5, -3.0), 0.9, 0.1);
        let eye = camera.eye(DVec3::ZERO, (16, 9)).unwrap();
        let at = eye.clip_from_world * Vec4::new(4.0, 2.5, -3.0, 1.0);
        assert!(at.x.abs() < 1e-4 && at.y.abs() < 1e-4 && at.w > 6.0, "{at}");
        // A metre to the right of the target is right in the picture, one above it is above.
        let right = Vec3::new(6.0, 0.0, 3.0).normalize_or_zero();
        let target = Vec3::new(4.0, 2.5, -3.0);
        assert!((eye.clip_from_world * (target + right).extend(1.0)).x > 0.5);
        assert!((eye.clip_from_world * (target + Vec3::Y).extend(1.0)).y > 0.5);
        // What depth is written from w is what the matrix has.
        let z = eye.depth_from_w.x * at.w + eye.depth_from_w.y;
        assert!((z - at.z).abs() < 1e-5, "{z} {}", at.z);
        for up in [1.0, -1.0] {
            let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.0, up, 0.0), 0.9, 0.1);
            assert!((camera.forward().y - up as f32).abs() < 1e-4);
        }
    }

    #[test]
    fn cameras_that_cannot_be_are_refused() {
        let good = Camera::look_at(DVec3::ZERO, DVec3::X, 0.9, 0.1);
        assert!(good.eye(DVec3::ZERO, (4, 4)).is_ok());
        assert!(matches!(good.eye(DVec3::ZERO, (0, 4)), Err(ViewError::Empty { .. })));
        let perspective = |fov_y, near| Projection::Perspective { fov_y, near };
        for bad in [
            Camera { eye: DVec3::NAN, ..good },
            Camera { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..good },
            Camera { projection: perspective(0.0, 0.1), ..good },
            Camera { projection: perspective(0.9, 0.0), ..good },
            Camera { projection: Projection::Matrix(Mat4::NAN), ..good },
            Camera { projection: Projection::Matrix(Mat4::ZERO), ..good },
        ] {
            assert!(
                matches!(bad.eye(DVec3::ZERO, (4, 4)), Err(ViewError::Camera { .. })),
                "{bad:?}"
            );
        }
    }

    #[test]
    fn eyes_are_relative_to_the_origin_to_the_last_millimetre() {
        let origin = DVec3::new(100_000.0, 0.0, -100_000.0);
        let offset = DVec3::new(0.123, 1.7, 0.456);
        let camera = Camera::look_at(origin + offset, origin, 0.9, 0.1);
        let eye = camera.eye(origin, (4, 4)).unwrap();
        assert!(eye.position.distance(offset.as_vec3()) < 1e-6);
    }
}
