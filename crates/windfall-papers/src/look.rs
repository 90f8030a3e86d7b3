//! What a loose leaf looks like, on the CPU: the references of the renderer's `season.wgsl` and `loose.wgsl`.

use crate::shared::{FallingLeaf, LitterLeaf};
use glam::{Quat, Vec2, Vec3};
use half::f16;
use windfall_core::path::{Fall, Landing, LeafFall, Phase};
use windfall_core::rng::{hash, unit};
use windfall_core::sway;
use windfall_gpu::Forest;
use windfall_gpu::internals::packing::pack_rotation;
use windfall_gpu::internals::shared::Model;

/// Seconds over which the twig's motion goes out of a leaf; `LETTING_GO` of the shaders.
const LETTING_GO: f32 = 1.5;
/// Share of the ambient light that reaches a leaf that has left its tree; `AMBIENT_IN_AIR` of the shaders.
const AMBIENT_IN_AIR: f32 = 0.9;
/// Colours of leaves by the loop of their path, as `lap_color` of the shaders has them.
const LAP_COLORS: [u32; 6] = [0x33_7928, 0x1f_8ea1, 0xa1_5a28, 0x1f_5aa1, 0x91_336b, 0x91_8c28];

/// A leaf in the air as the CPU poses it (VB 6.3): the reference of `loose_leaf` in `loose.wgsl`. `time` is on the
/// forest's clock.
pub fn airborne_leaf(
    (leaf, model): (&FallingLeaf, &Model),
    (fall, of, landing): (&Fall<'_>, &LeafFall, &Landing),
    forest: &Forest,
    time: f64,
) -> LitterLeaf {
    let moment = forest.moment();
    let elapsed = (time - f64::from(leaf.detach_time)) as f32;
    let [scale, stack] = sizes(leaf);
    let pose = fall.drawn_pose(of, landing, stack, moment.time);
    let bend = fall.own_way(&fall.variant(of), elapsed);
    let (mut position, mut orientation) = (pose.position, pose.orientation);
    if moment.sway {
        let twig = 1.0 - smooth(elapsed / LETTING_GO.min(landing.time));
        let foot = forest.terrain().height(of.origin.x, of.origin.z);
        let wind = forest.local_wind();
        position += sway::offset(wind, of.origin, foot, moment.time) * twig;
        let flutter = sway::flutter(wind, of.origin, moment.time);
        let half = flutter.xyz() / flutter.w * twig;
        orientation = Quat::from_xyzw(half.x, half.y, half.z, 1.0).normalize() * orientation;
    }
    let [material, ambient, bent_x, bent_y] = leaf.look.to_le_bytes();
    let ambient = f32::from(ambient) / 255.0;
    let ambient = ambient + (AMBIENT_IN_AIR - ambient) * bend;
    let [r, g, b] = match pose.phase {
        Phase::Falling { lap } if moment.color_loops => {
            let [r, g, b, _] = LAP_COLORS[lap as usize % LAP_COLORS.len()].to_le_bytes();
            [r, g, b]
        }
        _ => root_of_half(season_color(leaf, model, forest.season())),
    };
    let [orientation_xy, orientation_zw] = pack_rotation(orientation);
    LitterLeaf {
        position,
        scale,
        orientation_xy,
        orientation_zw,
        color: u32::from_le_bytes([r, g, b, unorm8(ambient)]),
        look: u32::from_le_bytes([material, bent_x, bent_y, unorm8(bend)]),
        landed_time: leaf.detach_time + leaf.landing.w,
        // Leaves shrink when they lie.
        vanish_time: f32::MAX,
        padding0: 0,
        padding1: 0,
    }
}

/// A landed leaf before it withers: the CPU reference of `loose_leaf` in the renderer's `loose.wgsl`.
pub fn litter_leaf(leaf: &FallingLeaf, model: &Model, season: f32) -> LitterLeaf {
    let up = upwards(unpack_rotation([leaf.lying_xy, leaf.lying_zw]));
    let [r, g, b] = root_of_half(season_color(leaf, model, season));
    let [material, _, bent_x, bent_y] = leaf.look.to_le_bytes();
    let [scale, stack] = sizes(leaf);
    LitterLeaf {
        position: leaf.landing.truncate() + up * stack,
        scale,
        orientation_xy: leaf.lying_xy,
        orientation_zw: leaf.lying_zw,
        color: u32::from_le_bytes([r, g, b, unorm8(0.9)]),
        look: u32::from_le_bytes([material, bent_x, bent_y, 255]),
        landed_time: leaf.detach_time + leaf.landing.w,
        vanish_time: leaf.vanish_time,
        padding0: 0,
        padding1: 0,
    }
}

/// The CPU reference of `ripeness` and `branch_ripeness` in the renderer's `season.wgsl`.
pub fn ripeness(season_offset: f32, seed: u32, from_center: Vec3) -> f32 {
    let wave = |direction: Vec3, draw: u32| {
        let turns = from_center.dot(direction) + unit(hash(seed, draw));
        (std::f32::consts::TAU * (turns - turns.floor())).sin()
    };
    let branch = 0.09 * wave(Vec3::new(0.83, 0.55, -0.61), 14)
        + 0.07 * wave(Vec3::new(-0.97, 1.13, 0.86), 15);
    season_offset + 0.12 * from_center.y + branch
}

/// The CPU reference of `season_color` in the renderer's `loose.wgsl`.
fn season_color(leaf: &FallingLeaf, model: &Model, season: f32) -> Vec3 {
    let u = |draw: u32| unit(hash(leaf.seed, draw));
    let own = (u(10) + u(12) - 1.0) * model.palette_spread;
    let phase = (season + leaf.ripe + own).clamp(0.0, 1.0);
    let brightness = Vec3::splat(0.82 + 0.36 * u(11));
    if model.palette_count < 2 {
        return brightness;
    }
    let x = phase * (model.palette_count - 1) as f32;
    let i = (x as u32).min(model.palette_count - 2) as usize;
    brightness * model.palette[i].lerp(model.palette[i + 1], x - i as f32).truncate()
}

/// Which side of a leaf that lies in this orientation is up.
fn upwards(lying: Quat) -> Vec3 {
    let up = lying * Vec3::Y;
    if up.y < 0.0 { -up } else { up }
}

/// Factor on the shape, and height over the ground at which it lies, metres.
fn sizes(leaf: &FallingLeaf) -> [f32; 2] {
    [leaf.scale_stack, leaf.scale_stack >> 16].map(|half| f16::from_bits(half as u16).to_f32())
}

/// A colour as `LooseLeaf::color` has it.
fn root_of_half(color: Vec3) -> [u8; 3] {
    (color * 0.5).max(Vec3::ZERO).map(f32::sqrt).to_array().map(unorm8)
}

fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn unorm8(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

pub fn from_snorm8(byte: u8) -> f32 {
    (f32::from(byte as i8) / 127.0).max(-1.0)
}

pub fn unpack_rotation([xy, zw]: [u32; 2]) -> Quat {
    let low = |v: u32| f32::from(v as u16 as i16) / 32767.0;
    let q = Quat::from_xyzw(low(xy), low(xy >> 16), low(zw), low(zw >> 16));
    if q.length_squared() > 0.0 { q.normalize() } else { Quat::IDENTITY }
}

/// The inverse of [`octahedral`].
pub fn from_octahedral(p: Vec2) -> Vec3 {
    let y = 1.0 - p.x.abs() - p.y.abs();
    let t = (-y).max(0.0);
    let fold = |v: f32| v + if v >= 0.0 { -t } else { t };
    Vec3::new(fold(p.x), y, fold(p.y)).normalize_or(Vec3::Y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_gpu::internals::text;

    #[test]
    fn numbers_are_those_of_the_shaders() {
        assert!(text::LOOSE.contains(&format!("const LETTING_GO: f32 = {LETTING_GO:?};")));
        assert!(text::LOOSE.contains(&format!("const AMBIENT_IN_AIR: f32 = {AMBIENT_IN_AIR:?};")));
        for color in LAP_COLORS {
            assert!(text::LOOSE.contains(&format!("{color:#08x}u")), "{color:#x}");
        }
    }
}
