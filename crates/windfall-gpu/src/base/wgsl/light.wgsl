const PI: f32 = 3.14159265;

// Where a pixel's samples are: WebGPU's pattern, one in each quarter.
const SAMPLE_PLACES = array<vec2<f32>, 4>(
    vec2(0.375, 0.125), vec2(0.875, 0.375), vec2(0.125, 0.625), vec2(0.625, 0.875),
);

// Whether an effect, a bit of frame.effects, is on.
fn has(effect: u32) -> bool {
    return (frame.effects & effect) != 0u;
}

// Radiance of the sky towards a direction, without the sun's disc: windfall_core::light::SkyTable, or
// the host's picture, equirectangular with +Z in the middle.
fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    if has(SKY_PICTURE) {
        let at = vec2(0.5 + atan2(direction.x, direction.z) / (2.0 * PI), acos(clamp(direction.y, -1.0, 1.0)) / PI);
        return textureSampleLevel(sky_picture, sky_sampler, at, 0.0).rgb * frame.sky_scale;
    }
    let heading = frame.sun_direction.xz / max(length(frame.sun_direction.xz), 1e-4);
    let flat = direction.xz / max(length(direction.xz), 1e-4);
    let at = sqrt(clamp(vec2(0.5 - 0.5 * dot(flat, heading), direction.y), vec2(0.0), vec2(1.0)));
    // Between the centres of the outer texels.
    return textureSampleLevel(sky_table, sky_sampler, (at * (SKY_SIDE - 1.0) + 0.5) / SKY_SIDE, 0.0).rgb;
}

// Light from all around on the two sides of a surface, as irradiance over pi: as
// windfall_core::light::Ambient.
struct TwoSided {
    front: vec3<f32>,
    back: vec3<f32>,
}

fn ambient_two_sided(n: vec3<f32>) -> TwoSided {
    let even = frame.ambient[0].rgb
        + frame.ambient[4].rgb * (n.x * n.y)
        + frame.ambient[5].rgb * (n.y * n.z)
        + frame.ambient[6].rgb * (3.0 * n.z * n.z - 1.0)
        + frame.ambient[7].rgb * (n.x * n.z)
        + frame.ambient[8].rgb * (n.x * n.x - n.y * n.y);
    let odd = frame.ambient[1].rgb * n.y + frame.ambient[2].rgb * n.z + frame.ambient[3].rgb * n.x;
    return TwoSided(max(even + odd, vec3(0.0)), max(even - odd, vec3(0.0)));
}

fn ambient(n: vec3<f32>) -> vec3<f32> {
    return ambient_two_sided(n).front;
}

// What reaches the eye of light that leaves a point: the air takes some and adds what it scatters,
// which over a long way is the sky at the horizon.
fn through_air(radiance: vec3<f32>, position: vec3<f32>) -> vec3<f32> {
    if frame.haze <= 0.0 {
        return radiance;
    }
    let way = position - frame.eye;
    let distance = length(way);
    let kept = exp(-distance * frame.haze);
    let direction = way / max(distance, 1e-4);
    let level = normalize(vec3(direction.x, max(direction.y, 0.015), direction.z));
    let around = ambient(level);
    var air = around; // a picture of the sky has trees at its horizon
    if !has(SKY_PICTURE) {
        // Low air lies in the shade of woods and hills more than the miles of it that the sky shows:
        // of the glow about the sun a part.
        air = min(sky_radiance(level), 2.2 * around);
    }
    return mix(air, radiance, kept);
}

// Whether the view explains what is seen: its colours are no light.
fn explains() -> bool {
    return frame.show == SHOW_COVERAGE || frame.show == SHOW_PARTS || frame.show == SHOW_NORMALS;
}

// A colour in place of the light of a surface that explains itself: what it is a part of, or its normal.
fn explained(normal: vec3<f32>, view: vec3<f32>, part: vec3<f32>) -> vec3<f32> {
    let shown = select(vec3(1.0), part * (0.3 + 0.7 * abs(dot(normal, view))), frame.show == SHOW_PARTS);
    return select(shown, pow(0.5 + 0.5 * normal, vec3(2.2)), frame.show == SHOW_NORMALS);
}

// A pattern that looks even about every pixel (Jimenez, "Next Generation Post Processing in Call of
// Duty", SIGGRAPH 2014).
fn interleaved_noise(pixel: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

// Point i of n of a disc, turned by `turn` (Vogel, "A better way to construct the sunflower head",
// 1979).
fn vogel(i: u32, n: u32, turn: f32) -> vec2<f32> {
    let angle = f32(i) * 2.39996323 + turn;
    return sqrt((f32(i) + 0.5) / f32(n)) * vec2(cos(angle), sin(angle));
}

// Tangent of half of the sun's angle, widened by the haze about it.
const SUN_SIZE: f32 = 0.009;
// Widest penumbra's radius, metres.
const WIDEST: f32 = 0.35;

// Depth in a shadow map, 0 nearest to the sun, from what a map holds, and back.
fn from_sun(depth: f32) -> f32 {
    return select(depth, 1.0 - depth, frame.shadow_reversed == 1u);
}

// Share of the sun that reaches a point.
//
// Percentage-closer soft shadows (Fernando, SIGGRAPH 2005): as wide as the mean distance of what is
// in the way asks for. `normal` is the receiving plane's, along which depths are compared, so that
// slanting light needs no more bias than the plane's own; zero for what has none, as a leaf among
// leaves. `bias` is in texels of the cascade.
fn sun_visibility(position: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>, taps: u32, bias: f32) -> f32 {
    return sun_visibility_in(position, normal, pixel, vec2(0u, taps), taps, bias);
}

// The mean over some of its samples: from one up to another.
fn sun_visibility_in(
    position: vec3<f32>,
    normal: vec3<f32>,
    pixel: vec2<f32>,
    some: vec2<u32>,
    taps: u32,
    bias: f32,
) -> f32 {
    let distance = length(position - frame.eye);
    if frame.shadow_ends.w == 0.0 || distance >= frame.shadow_ends.z {
        return 1.0;
    }
    let noise = interleaved_noise(pixel);
    // Neighbouring cascades are mixed by pixel over the last of each: no farther, since on a leaf that
    // they see differently the mixture shows.
    let reach = distance * (1.0 + 0.06 * noise);
    let cascade = select(select(2u, 1u, reach < frame.shadow_ends.y), 0u, reach < frame.shadow_ends.x);
    let map = frame.shadow_from_world[cascade];
    let texel = frame.shadow_texels[cascade];
    let sun = frame.sun_direction;
    // Rows of the map's matrix: along its columns, its rows, and its depth, per metre.
    let right = vec3(map[0].x, map[1].x, map[2].x);
    let up = vec3(map[0].y, map[1].y, map[2].y);
    let per_metre = length(right);
    let depth_per_metre = length(vec3(map[0].z, map[1].z, map[2].z));
    let facing = dot(normal, sun);
    // Metres towards the sun that the receiving plane rises per metre along right and up.
    var rise = vec2(0.0);
    if facing > 0.0 {
        rise = clamp(-vec2(dot(normal, right), dot(normal, up)) / (per_metre * max(facing, 0.02)), vec2(-8.0), vec2(8.0));
    }
    let lifted = position + normal * (texel * 0.7) + sun * (texel * bias);
    let at = (map * vec4(lifted, 1.0)).xyz;
    // The part of the map that is in use.
    let scale = frame.shadow_texels.w;
    let uv = (at.xy * vec2(0.5, -0.5) + 0.5) * scale;
    let uv_per_metre = per_metre * vec2(0.5, -0.5) * scale;
    // Few samples are not turned: on a small surface their noise would show more than their steps.
    let turn = select(0.7, noise * 2.0 * PI, taps > 4u);
    var radius = max(select(0.02, 0.045, taps > 4u), 1.3 * texel);
    if has(SOFT_SHADOWS) && taps > 8u && cascade < 2u {
        let size = vec2<f32>(textureDimensions(shadow_maps));
        let last = vec2<i32>(size * scale) - 1;
        let search = max(0.16, 2.0 * texel);
        var sum = 0.0;
        var count = 0.0;
        for (var i = 0u; i < 6u; i++) {
            let offset = vogel(i, 6u, turn + 1.0) * search;
            let there = clamp(vec2<i32>((uv + offset * uv_per_metre) * size), vec2(0), last);
            let depth = from_sun(textureLoad(shadow_maps, there, cascade, 0));
            let gap = (at.z - dot(offset, rise) * depth_per_metre - depth) / depth_per_metre;
            if gap > texel {
                sum += gap;
                count += 1.0;
            }
        }
        radius = clamp(SUN_SIZE * sum / max(count, 1.0), 1.3 * texel, WIDEST);
    }
    var lit = 0.0;
    for (var i = some.x; i < some.y; i++) {
        let offset = vogel(i, taps, turn) * radius;
        let there = clamp(uv + offset * uv_per_metre, vec2(0.0), vec2(scale));
        let depth = from_sun(at.z - dot(offset, rise) * depth_per_metre);
        lit += textureSampleCompareLevel(shadow_maps, shadow_sampler, there, cascade, depth);
    }
    // Far shadows fade into the light that is left without them.
    let fade = smoothstep(0.75 * frame.shadow_ends.z, frame.shadow_ends.z, distance);
    return mix(lit / f32(some.y - some.x), 0.8, fade);
}
