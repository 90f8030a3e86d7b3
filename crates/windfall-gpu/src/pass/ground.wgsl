// The forest floor.

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

// A square of PATCH cells a side, each `step` cells of the terrain wide; or what continues it from the terrain's rim out
// to the horizon, level along its axis as the terrain is there.
struct Square {
    // Its first corner, in cells of the terrain.
    @location(0) first: vec2<f32>,
    @location(1) step: f32,
    // Where cells twice as wide take over, metres from the eye on the level.
    @location(2) end: f32,
    // -1, 0 or 1 along x and z: beyond which rim it lies.
    @location(3) beyond: vec2<i32>,
}

// A vertex of the terrain whose neighbours are so many cells away.
struct Ground {
    position: vec3<f32>,
    slope: vec2<f32>,
}

fn ground_at(place: vec2<i32>, step: i32) -> Ground {
    let last = last_sample();
    let at = clamp(place, vec2(0), vec2(last));
    let low = max(at - step, vec2(0));
    let high = min(at + step, vec2(last));
    let rise = vec2(
        height_sample(vec2(high.x, at.y)) - height_sample(vec2(low.x, at.y)),
        height_sample(vec2(at.x, high.y)) - height_sample(vec2(at.x, low.y)),
    );
    let flat = (vec2<f32>(at) - 0.5 * f32(last)) * terrain[1];
    return Ground(vec3(flat.x, height_sample(at), flat.y), rise / (vec2<f32>(high - low) * terrain[1]));
}

// Neighbouring squares have cells of one width, or of twice it: where these begin, every second vertex moves to
// the one before, so that nothing jumps and no gap opens (Strugar, "Continuous distance-dependent level of detail for
// rendering heightmaps", JGT 2009).
@vertex
fn vertex(@builtin(vertex_index) index: u32, square: Square) -> Varyings {
    let corner = vec2<i32>(vec2(index % (PATCH + 1u), index / (PATCH + 1u)));
    let step = i32(square.step);
    let beyond = square.beyond != vec2(0);
    // Beyond the rim a square has one row of cells: its others have no width.
    let outside = (beyond & (square.beyond == sign(corner))) | ((square.beyond < vec2(0)) & (corner < vec2(i32(PATCH))));
    let rim = select(vec2(0), vec2(last_sample()), square.beyond > vec2(0));
    let place = select(vec2<i32>(square.first) + corner * step, rim, beyond);
    let fine = ground_at(place, step);
    // The last row is one of the wider cells too.
    let odd = (place / step) % 2;
    let coarse = ground_at(select(place - odd * step, place, place >= vec2(last_sample())), 2 * step);
    let away = distance(fine.position.xz, frame.eye.xz);
    let share = smoothstep(MORPH * square.end, square.end, away);
    let slope = select(mix(fine.slope, coarse.slope, share), vec2(0.0), beyond);
    var out: Varyings;
    out.world = mix(fine.position, coarse.position, share);
    let horizon = select(vec2(0.0), vec2<f32>(square.beyond) * HORIZON, outside);
    out.world += vec3(horizon.x, 0.0, horizon.y);
    out.clip = frame.clip_from_world * vec4(out.world, 1.0);
    out.normal = normalize(vec3(-slope.x, 1.0, -slope.y));
    return out;
}

// Whether single dead leaves show. Settled when the pipeline is made, since software drivers run both sides of every
// branch.
override detail: bool = true;
// Cells of the litter in a metre.
const LITTER_CELLS: f32 = 8.3;

// How trodden the ground is at a place, 0 to 1.
fn trodden(at: vec2<f32>, wobble: f32) -> f32 {
    var worn = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let half_width = frame.trail_widths[i];
        if half_width > 0.0 {
            let trail = frame.trails[i];
            let way = trail.zw - trail.xy;
            let along = clamp(dot(at - trail.xy, way) / max(dot(way, way), 1e-6), 0.0, 1.0);
            let off = distance(at, trail.xy + way * along) / half_width;
            worn = max(worn, 1.0 - smoothstep(0.55, 1.25, off + wobble));
        }
    }
    return worn;
}

// What the floor is made of at a place.
struct Floor {
    color: vec3<f32>,
    // 0 in the hollows to 1 on top.
    height: f32,
    // How its surface leans, along x and z.
    lean: vec2<f32>,
}

fn dead_leaf(key: u32) -> vec3<f32> {
    var browns = array<vec3<f32>, 5>(
        vec3(0.165, 0.085, 0.034), vec3(0.240, 0.135, 0.045), vec3(0.095, 0.054, 0.032),
        vec3(0.190, 0.088, 0.030), vec3(0.270, 0.185, 0.075),
    );
    // Some have only just fallen.
    let fresh = smoothstep(0.55, 1.0, unit(hash(key, 8u)));
    return mix(browns[hash(key, 3u) % 5u], frame.litter, 0.85 * fresh) * (0.55 + 0.75 * unit(hash(key, 4u)));
}

fn dead_leaves_mean() -> vec3<f32> {
    return mix(vec3(0.165, 0.095, 0.040), frame.litter, 0.2) * 0.84;
}

// Share of a pixel of width `wide` about `x` within `reach` of 0.
fn box_share(x: f32, reach: f32, wide: f32) -> f32 {
    return max(min(x + 0.5 * wide, reach) - max(x - 0.5 * wide, -reach), 0.0) / wide;
}

// A pixel on the floor, in cells of the litter: the way to its right and to its lower neighbour, and the width up to
// which single leaves show.
struct Footprint {
    right: vec2<f32>,
    down: vec2<f32>,
    width: f32,
}

// How wide a pixel is along an axis.
fn wide_along(pixel: Footprint, axis: vec2<f32>) -> f32 {
    return max(abs(dot(axis, pixel.right)) + abs(dot(axis, pixel.down)), 0.03);
}

// Old leaves on the floor, one in a cell of a jittered grid; later layers lie over earlier ones. Seen at a grazing
// angle a pixel is long and thin: it has of each leaf as much as it covers along and across the leaf.
fn litter(at: vec2<f32>, pixel: Footprint, under: Floor, covered: f32, clumps: f32) -> Floor {
    var top = under;
    let share = 1.0 - pow(1.0 - 0.5 * covered, 3.0);
    let far = Floor(mix(under.color, dead_leaves_mean() * clumps, share), mix(under.height, 0.55, share), under.lean);
    // Smaller than a pixel, leaves are their mean.
    let blur = smoothstep(0.3, 1.0, pixel.width);
    if !detail || blur >= 1.0 {
        return far;
    }
    let around = 0.5 * max(length(pixel.right), length(pixel.down));
    for (var layer = 0u; layer < 3u; layer++) {
        let p = at * (1.0 - 0.16 * f32(layer)) + vec2(7.3, 3.1) * f32(layer);
        let cell = floor(p);
        for (var j = -1; j <= 1; j++) {
            for (var i = -1; i <= 1; i++) {
                let c = vec2<u32>(vec2<i32>(cell) + vec2(i, j));
                let key = hash(hash(11u + layer, c.x), c.y);
                if unit(hash(key, 5u)) > covered {
                    continue;
                }
                let d = (p - cell) - vec2(f32(i), f32(j)) - vec2(unit(key), unit(hash(key, 1u)));
                let half_length = 0.42 + 0.26 * unit(hash(key, 6u));
                let reach = half_length + around;
                if dot(d, d) > reach * reach {
                    continue;
                }
                let angle = unit(hash(key, 2u)) * 2.0 * PI;
                let axis = vec2(cos(angle), sin(angle));
                let along = dot(axis, d);
                let across = axis.x * d.y - axis.y * d.x;
                let wide = vec2(wide_along(pixel, axis), wide_along(pixel, vec2(-axis.y, axis.x)));
                // The middle of what the pixel covers along the leaf.
                let middle = 0.5 * (min(along + 0.5 * wide.x, half_length) + max(along - 0.5 * wide.x, -half_length));
                // A leaf: pointed at both ends, its rim a little torn.
                let s = middle / half_length;
                let torn = 1.0 + 0.14 * sin(along * 23.0 + unit(key) * 9.0) + 0.08 * sin(along * 51.0);
                let breadth = half_length * (0.42 + 0.3 * unit(hash(key, 7u))) * max(1.0 - s * s, 0.0) * torn;
                let length_share = box_share(along, half_length, wide.x);
                let edge = length_share * box_share(across, breadth, wide.y);
                // Its shadow on those below.
                let outside = abs((breadth - abs(across)) / wide.y + 0.25);
                top.color *= mix(1.0, mix(0.55, 1.0, min(outside, 1.0)), length_share);
                let rib = 1.0 - smoothstep(0.0, 0.035 + wide.y, abs(across));
                let curl = across / half_length;
                let color = dead_leaf(key) * (0.9 + 0.3 * rib);
                top.color = mix(top.color, color, edge);
                top.height = mix(top.height, 0.5 + 0.25 * f32(layer), edge);
                let own = vec2(unit(hash(key, 12u)), unit(hash(key, 13u))) - 0.5;
                let side = vec2(-axis.y, axis.x) * curl * 1.4;
                top.lean = mix(top.lean, own * 0.9 + side, edge);
            }
        }
    }
    return Floor(mix(top.color, far.color, blur), mix(top.height, far.height, blur), mix(top.lean, far.lean, blur));
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    // Tufts and heaped leaves stand up: where the eye's way meets them, by one step from the bare
    // ground (Kaneko et al., "Detailed Shape Representation with Parallax Mapping", ICAT 2001). It
    // is what keeps the far ground from looking like a painted board.
    let eye_way = in.world - frame.eye;
    // How steeply the eye looks at the slope: the tangent of the angle between them.
    let facing = dot(normalize(in.normal), -normalize(eye_way));
    let steep = facing / sqrt(max(1.0 - facing * facing, 1e-4));
    let relief_step = min(0.11 / max(steep, 0.012), 3.0);
    let toward_eye = -eye_way.xz / max(length(eye_way.xz), 1e-3);
    let heap = clamp(0.5 + 1.4 * fractal_noise2(in.world.xz * 2.1, 0.0, 28u) + 0.8 * fractal_noise2(in.world.xz * 0.45, 0.0, 29u), 0.0, 1.0);
    let at = in.world.xz + toward_eye * (relief_step * heap);
    // Size of a pixel on the ground: seen at a grazing angle it is long and thin; the mean of both
    // sides keeps the detail, and the fourfold samples keep it still.
    let dx = dpdx(in.world.xz);
    let dy = dpdy(in.world.xz);
    let width = sqrt(abs(dx.x * dy.y - dx.y * dy.x)) * 1.4;
    let long = max(length(dx), length(dy));
    // Beyond stands the backdrop.
    if has(BACKDROP) && dot(in.world.xz, in.world.xz) > frame.backdrop.w * frame.backdrop.w {
        discard;
    }
    let broad = fractal_noise2(at * 0.045, long * 0.045, 20u);
    let growth = ground_growth(at, width);
    let fine = fractal_noise2(at * 3.3, width * 3.3, 22u);
    let tufts = fractal_noise2(at * 1.15, width * 1.15, 27u);
    let grains = fractal_noise2(at * 29.0, width * 29.0, 23u);
    let worn = trodden(at, 0.8 * tufts + 0.5 * fine);
    let grassy = growth * (1.0 - worn);
    // Short grass: greener in the hollows, straw where it is dry.
    let dry = smoothstep(-0.2, 0.3, broad + 0.6 * tufts);
    var grass = mix(vec3(0.044, 0.060, 0.016), vec3(0.112, 0.102, 0.036), dry);
    grass *= clamp(1.0 + 1.3 * fine + 0.9 * tufts + 0.8 * grains, 0.25, 2.2);
    let earth = mix(vec3(0.068, 0.046, 0.029), vec3(0.150, 0.108, 0.070), worn) * clamp(1.0 + 0.9 * fine + 1.1 * grains + 0.6 * tufts, 0.3, 2.0);
    let bumps = vec2(fine, tufts) * 0.8 + grains * 0.6;
    let under = Floor(mix(earth, grass, grassy), 0.28 + 0.5 * tufts, bumps * 0.6);
    let drifts = fractal_noise2(at * 0.27 + 40.0, width * 0.27, 24u) + 0.5 * fine + 0.35 * broad;
    let covered = mix(0.3, 0.98, smoothstep(-0.28, 0.14, drifts)) * mix(1.0, 0.42, grassy) * (1.0 - 0.82 * worn);
    let clumps = clamp(0.55 + 0.75 * heap + 1.0 * fine + 0.8 * grains, 0.25, 1.9);
    let short = min(length(dx), length(dy));
    let pixel = Footprint(dx * LITTER_CELLS, dy * LITTER_CELLS, max(short, long / 3.0) * 1.2 * LITTER_CELLS);
    let cover = litter(at * LITTER_CELLS, pixel, under, covered, clumps);
    let normal = normalize(in.normal);
    let relief = 1.0 - smoothstep(0.02, 0.12, width);
    let leaning = normalize(normal + vec3(cover.lean.x, 0.0, cover.lean.y) * (0.25 + 0.75 * relief));
    let sun = max(dot(leaning, frame.sun_direction), 0.0);
    // Rough ground darkens itself, the more the lower the light.
    let cavity = clamp(0.42 + 0.5 * cover.height + 0.4 * heap + 0.4 * grains + 0.5 * fine, 0.3, 1.3);
    let reach = sun_visibility(in.world, normal, in.clip.xy, frame.shadow_taps, 1.0);
    let light = frame.sun_color * (sun / PI * reach * mix(cavity, 1.0, 0.5)) + ambient(leaning) * cavity;
    return vec4(through_air(cover.color * light, in.world), 1.0);
}
