//! Numbers in fewer bits, as WGSL unpacks them.

use glam::{Quat, UVec4, Vec2, Vec3, Vec4};
use half::f16;

/// A vector's bits.
pub fn words(v: Vec4) -> UVec4 {
    UVec4::from_array(v.to_array().map(f32::to_bits))
}

/// Two numbers as `unpack2x16float` has them.
pub fn pack_halfs(v: Vec2) -> u32 {
    let [x, y] = v.to_array().map(|v| u32::from(f16::from_f32(v).to_bits()));
    x | y << 16
}

/// A rotation as two pairs for `unpack2x16snorm`.
pub fn pack_rotation(q: Quat) -> [u32; 2] {
    let [x, y, z, w] = q.to_array().map(snorm16);
    [x | y << 16, z | w << 16]
}

fn snorm16(v: f32) -> u32 {
    u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16)
}

/// A number between -1 and 1 in a byte.
pub fn snorm8(v: f32) -> u8 {
    (v.clamp(-1.0, 1.0) * 127.0).round() as i8 as u8
}

/// A vector between -1 and 1 in four bytes, the last of them 0.
pub fn snorm(v: Vec3) -> [i8; 4] {
    let scaled = (v.clamp(Vec3::NEG_ONE, Vec3::ONE) * 127.0).round();
    [scaled.x as i8, scaled.y as i8, scaled.z as i8, 0]
}

/// A unit vector as a point of the square -1..1; the shader's is in `wgsl/season.wgsl`.
pub fn octahedral(n: Vec3) -> Vec2 {
    let p = Vec2::new(n.x, n.z) / (n.x.abs() + n.y.abs() + n.z.abs()).max(f32::MIN_POSITIVE);
    if n.y >= 0.0 {
        return p;
    }
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

/// A time as the sum of two single-precision numbers: rounded, and what that leaves out.
pub fn split_time(seconds: f64) -> [f32; 2] {
    let high = seconds as f32;
    [high, (seconds - f64::from(high)) as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn split_times_keep_microseconds_after_ten_days() {
        let time = 864_000.123_456_7;
        let [high, low] = split_time(time);
        assert!((f64::from(high) + f64::from(low) - time).abs() < 1e-6);
        assert!((f64::from(high) - time).abs() > 1e-3, "one number alone must not do");
    }
}
