//! The rotation and the size that bring one set of points closest to another.

use glam::{DMat4, DQuat, DVec3, DVec4, Quat, Vec3};

/// A rotation and a size.
#[derive(Clone, Copy)]
pub(super) struct Similarity {
    pub rotation: Quat,
    pub scale: f32,
}

/// The similarity that brings `from` closest to `to`, both seen from their middles, in the sense
/// of least squares (Horn 1987: the rotation is the main eigenvector of a symmetric 4×4 matrix).
pub(super) fn fit(
    from: &[Vec3],
    from_middle: Vec3,
    to: &[Vec3],
    to_middle: Vec3,
) -> Option<Similarity> {
    // S[i][j]: the sum of from.i * to.j.
    let mut s = [DVec3::ZERO; 3];
    let mut size = 0.0;
    for (&a, &b) in from.iter().zip(to) {
        let (a, b) = ((a - from_middle).as_dvec3(), (b - to_middle).as_dvec3());
        size += a.length_squared();
        s[0] += b * a.x;
        s[1] += b * a.y;
        s[2] += b * a.z;
    }
    let [x, y, z] = s;
    let shift = (3.0 * (x.length_squared() + y.length_squared() + z.length_squared())).sqrt();
    // The shift makes every eigenvalue positive, so that powers of the matrix turn to the largest.
    let mut m = DMat4::from_cols(
        DVec4::new(x.x + y.y + z.z, y.z - z.y, z.x - x.z, x.y - y.x),
        DVec4::new(y.z - z.y, x.x - y.y - z.z, x.y + y.x, z.x + x.z),
        DVec4::new(z.x - x.z, x.y + y.x, y.y - x.x - z.z, y.z + z.y),
        DVec4::new(x.y - y.x, z.x + x.z, y.z + z.y, z.z - x.x - y.y),
    ) + DMat4::from_diagonal(DVec4::splat(shift));
    // The 2²⁰th power: enough for a needle fifty times as long as wide.
    for _ in 0..20 {
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z + m.w_axis.w;
        if trace <= 0.0 {
            return None;
        }
        m *= 1.0 / trace;
        m *= m;
    }
    let columns = [m.x_axis, m.y_axis, m.z_axis, m.w_axis];
    let main =
        columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let main = main.try_normalize()?;
    let rotation = DQuat::from_xyzw(main.y, main.z, main.w, main.x);
    let along: f64 = from
        .iter()
        .zip(to)
        .map(|(&a, &b)| (rotation * (a - from_middle).as_dvec3()).dot((b - to_middle).as_dvec3()))
        .sum();
    let scale = (along / size) as f32;
    (scale.is_finite() && scale > 0.0).then(|| Similarity { rotation: rotation.as_quat(), scale })
}
