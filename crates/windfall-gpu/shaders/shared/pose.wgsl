// Where a falling leaf is: the twin of windfall_core::path (playback, landing, variation), of
// windfall_core::wind and of windfall_core::forest::Terrain. How tables are read differs between
// strategies: path_sample, path_start, path_joint, path_record, path_group and ground_sample are
// declared by the pass.


fn quat_mul(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn quat_conjugate(q: vec4<f32>) -> vec4<f32> {
    return vec4(-q.xyz, q.w);
}

fn quat_rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn quat_y(angle: f32) -> vec4<f32> {
    return vec4(0.0, sin(angle * 0.5), 0.0, cos(angle * 0.5));
}

// Spherical interpolation by the shorter way.
fn quat_slerp(a: vec4<f32>, b0: vec4<f32>, s: f32) -> vec4<f32> {
    let d0 = dot(a, b0);
    let b = select(b0, -b0, d0 < 0.0);
    let d = min(abs(d0), 1.0);
    if d > 0.9995 {
        return normalize(mix(a, b, s));
    }
    let angle = acos(d);
    return (a * sin(angle * (1.0 - s)) + b * sin(angle * s)) / sin(angle);
}

// The shortest rotation that takes unit vector a to unit vector b.
fn quat_arc(a: vec3<f32>, b: vec3<f32>) -> vec4<f32> {
    return normalize(vec4(cross(a, b), 1.0 + dot(a, b)));
}

fn smooth_step(x: f32) -> f32 {
    let s = clamp(x, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

// Sine and cosine of an angle in 2^-32 turns: the nearest quarter turn is split off exactly, the
// rest is a short series.
fn sin_cos_turns(turns: u32) -> vec2<f32> {
    let quarter = (turns + (1u << 29u)) >> 30u;
    let x = f32(bitcast<i32>(turns - (quarter << 30u))) * (2.0 * PI / 4294967296.0);
    let x2 = x * x;
    let s = x * (1.0 - x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0))));
    let c = 1.0 - x2 * (0.5 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40320.0))));
    let turned = select(vec2(c, -s), vec2(s, c), (quarter & 1u) == 0u);
    return select(-turned, turned, (quarter & 2u) == 0u);
}

// --- the ground ---------------------------------------------------------------------------------

struct Ground {
    height: f32,
    normal: vec3<f32>,
}

fn ground_at(at_world: vec2<f32>) -> Ground {
    let last = f32(fall.ground_side - 1u);
    let raw = at_world / fall.ground_cell + last * 0.5;
    let at = clamp(raw, vec2(0.0), vec2(last));
    let inside = select(vec2(0.0), vec2(1.0), raw == at);
    let low = min(floor(at), vec2(last - 1.0));
    let first = u32(low.y) * fall.ground_side + u32(low.x);
    let b = ground_sample(first + 1u);
    let c = ground_sample(first + fall.ground_side);
    let f = at - low;
    var base = ground_sample(first);
    var gradient = vec2(b - base, c - base);
    var offset = f;
    if f.x + f.y > 1.0 {
        base = ground_sample(first + fall.ground_side + 1u);
        gradient = vec2(base - c, base - b);
        offset = f - 1.0;
    }
    let slope = gradient * inside / fall.ground_cell;
    return Ground(base + dot(gradient, offset), normalize(vec3(-slope.x, 1.0, -slope.y)));
}

// --- the wind -----------------------------------------------------------------------------------

const WIND_PERIOD: f32 = 1024.0;

fn wind_displacement(origin: vec3<f32>, detach_time: f32, elapsed: f32) -> vec2<f32> {
    if fall.wind_fastest == 0.0 {
        return vec2(0.0);
    }
    let start = detach_time - WIND_PERIOD * floor(detach_time / WIND_PERIOD);
    let lag = max(fall.wind_response, 1e-4);
    let fade = exp(max(-elapsed / lag, -60.0));
    var d = fall.wind_mean * (elapsed - lag * (1.0 - fade));
    let part = elapsed - WIND_PERIOD * floor(elapsed / WIND_PERIOD);
    let late = dot(fall.wind_travel, origin.xz) * fall.wind_slowness;
    let a = 1.0 / lag;
    for (var i = 0u; i < 4u; i++) {
        let gust = fall.gusts[i]; // amplitude x and z, cycles, phase
        let omega = 2.0 * PI * gust.z / WIND_PERIOD;
        let turns0 = gust.z * ((start - late) / WIND_PERIOD) + gust.w;
        let first = turns0 - floor(turns0);
        let turns1 = first + gust.z * part / WIND_PERIOD;
        let angle0 = 2.0 * PI * first;
        let angle1 = 2.0 * PI * (turns1 - floor(turns1));
        let s0 = sin(angle0);
        let c0 = cos(angle0);
        let s1 = sin(angle1);
        let c1 = cos(angle1);
        let plain = (c0 - c1) / omega;
        let lagging = ((a * s0 + omega * c0) - fade * (a * s1 + omega * c1)) / (a * a + omega * omega);
        d += gust.xy * (plain - lagging);
    }
    return d;
}

// --- one leaf's share of variety ----------------------------------------------------------------

struct LeafFall {
    origin: vec3<f32>,
    twig: vec4<f32>,
    seed: u32,
    path_group: u32,
    detach_time: f32,
}

struct Variant {
    path: PathRecord,
    joint: JointRecord,
    start: u32,
    yaw: f32,
    scale: vec2<f32>,
    rate: f32,
}

fn pick(u: f32, n: u32) -> u32 {
    return min(u32(u * f32(n)), max(n, 1u) - 1u);
}

fn positive_mod(a: f32, b: f32) -> f32 {
    return a - b * floor(a / b);
}

fn variant_of(leaf: LeafFall) -> Variant {
    let members = path_group(leaf.path_group);
    var out: Variant;
    if fall.paper_variation == 1u {
        let p = leaf.origin;
        out.path = path_record(members.x);
        let starts = max(out.path.start_count, 2u) - 1u;
        let start = pick(positive_mod(p.y * p.x * 37.0, f32(starts)) / f32(starts), starts);
        out.joint = path_joint(out.path.first_joint);
        out.start = path_start(out.path.first_start + start);
        out.yaw = radians(positive_mod(p.x * p.y * p.z * 37.0, 360.0));
        out.scale = vec2(positive_mod(p.z * p.y, 3.0), positive_mod(p.x * p.y, 3.0));
        out.rate = 1.0;
        return out;
    }
    out.path = path_record(members.x + pick(unit(hash(leaf.seed, 1u)), members.y));
    out.joint = path_joint(out.path.first_joint + pick(unit(hash(leaf.seed, 2u)), out.path.joint_count));
    out.start = path_start(out.path.first_start + pick(unit(hash(leaf.seed, 3u)), out.path.start_count));
    out.yaw = unit(hash(leaf.seed, 4u)) * (2.0 * PI);
    out.scale = vec2(fall.scale_low + (fall.scale_high - fall.scale_low) * unit(hash(leaf.seed, 5u)));
    out.rate = fall.rate_low + (fall.rate_high - fall.rate_low) * unit(hash(leaf.seed, 6u));
    return out;
}

// --- the path -----------------------------------------------------------------------------------

fn sample_index(variant: Variant, i: u32) -> u32 {
    return select(
        variant.joint.tail + i - variant.joint.blend_start,
        variant.path.first_sample + i,
        i < variant.joint.blend_start,
    );
}

struct CurvePoint {
    position: vec3<f32>,
    low: f32,
    orientation: vec4<f32>,
}

// Catmull-Rom through four samples, displacement and quaternion alike.
fn curve(variant: Variant, u: f32) -> CurvePoint {
    let i = min(u32(u), variant.joint.from_sample - 1u);
    let x = u - f32(i);
    let s0 = path_sample(sample_index(variant, max(i, 1u) - 1u));
    let s1 = path_sample(sample_index(variant, i));
    let s2 = path_sample(sample_index(variant, i + 1u));
    let s3 = path_sample(sample_index(variant, i + 2u));
    let x2 = x * x;
    let x3 = x2 * x;
    let w0 = 0.5 * (-x + 2.0 * x2 - x3);
    let w1 = 0.5 * (2.0 - 5.0 * x2 + 3.0 * x3);
    let w2 = 0.5 * (x + 4.0 * x2 - 3.0 * x3);
    let w3 = 0.5 * (-x2 + x3);
    let near = s1.place.xyz;
    var out: CurvePoint;
    out.position = near + w0 * (s0.place.xyz - near) + w2 * (s2.place.xyz - near) + w3 * (s3.place.xyz - near);
    let q = w0 * s0.orientation + w1 * s1.orientation + w2 * s2.orientation + w3 * s3.orientation;
    out.orientation = q / max(length(q), 1e-3);
    out.low = s1.place.w + (s2.place.w - s1.place.w) * x;
    return out;
}

fn path_time(variant: Variant, elapsed: f32) -> f32 {
    let soft = fall.soft_time;
    let t = select(elapsed - max(soft, 0.0) * 0.5, elapsed * elapsed / (2.0 * soft), elapsed < soft);
    return t * variant.rate;
}

// A place in the air. `bend` is 0 on the twig and 1 once the leaf follows its path alone.
struct Pose {
    position: vec3<f32>,
    orientation: vec4<f32>,
    bend: f32,
    lap: u32,
}

// Pose `elapsed` seconds after the detachment as if there were no ground.
fn airborne(leaf: LeafFall, variant: Variant, elapsed: f32) -> Pose {
    let joint = variant.joint;
    let start = path_sample(variant.path.first_sample + variant.start);
    let begin = start.place.xyz;
    let u = f32(variant.start) + path_time(variant, elapsed) * variant.path.rate;
    let beyond = u - f32(joint.from_sample);
    let lap_samples = f32(joint.from_sample - joint.to_sample);
    var k = 0u;
    var local = u;
    var before = begin;
    if beyond >= 0.0 {
        let full = floor(beyond / lap_samples);
        let rest = clamp(beyond - full * lap_samples, 0.0, lap_samples);
        k = u32(full) + 1u;
        local = f32(joint.to_sample) + rest;
        before = path_sample(variant.path.first_sample + joint.to_sample).place.xyz;
    }
    let at = curve(variant, local);
    let h = joint.half_turn;
    // The laps before are a geometric series of turns of one lap's displacement.
    let kh = sin_cos_turns(k * h);
    var sum = joint.lap * f32(k);
    if h != 0u {
        let own = sin_cos_turns(h);
        // Sine and cosine of (k - 1) h.
        let s = kh.x * own.y - kh.y * own.x;
        let c = kh.y * own.y + kh.x * own.x;
        let ratio = kh.x / own.x;
        sum = vec3((joint.lap.x * c + joint.lap.z * s) * ratio, sum.y, (joint.lap.z * c - joint.lap.x * s) * ratio);
    }
    // A turn by 2 k h about Y: the quaternion has the sine and cosine of half of it.
    let turn = vec4(0.0, kh.x, 0.0, kh.y);
    var d = (before - begin) + sum + quat_rotate(turn, at.position - before);
    var drop = start.place.w - at.low;
    if k > 0u {
        let end = path_sample(sample_index(variant, joint.from_sample));
        drop = start.place.w - end.place.w - joint.lap.y * beyond / lap_samples;
    }
    d = vec3(d.x * variant.scale.x, d.y, d.z * variant.scale.y);
    let yaw = quat_y(variant.yaw);
    let blown = wind_displacement(leaf.origin, leaf.detach_time, elapsed);
    var out: Pose;
    out.position = leaf.origin + quat_rotate(yaw, d) + vec3(blown.x, 0.0, blown.y);
    out.lap = k;
    out.bend = select(1.0, smooth_step(drop / fall.soft_drop), fall.soft_drop > 0.0);
    out.orientation = quat_mul(quat_mul(yaw, turn), at.orientation);
    if out.bend < 1.0 {
        let first = quat_mul(yaw, start.orientation);
        let from_twig = quat_mul(quat_conjugate(first), leaf.twig);
        out.orientation = quat_mul(out.orientation, quat_slerp(from_twig, vec4(0.0, 0.0, 0.0, 1.0), out.bend));
    }
    return out;
}

// --- landing ------------------------------------------------------------------------------------

struct Landing {
    time: f32,
    position: vec3<f32>,
    orientation: vec4<f32>,
}

fn settle_time(landing_time: f32) -> f32 {
    return clamp(fall.settle_time, 0.0, max(landing_time, 0.0));
}

// Time whose orientation a leaf has when it has settled by the fraction `done`.
fn settling(landing_time: f32, done: f32) -> f32 {
    let settle = settle_time(landing_time);
    return landing_time - settle + settle * (done - 0.5 * done * done);
}

fn clearance(leaf: LeafFall, variant: Variant, elapsed: f32) -> f32 {
    let p = airborne(leaf, variant, elapsed).position;
    return p.y - ground_at(p.xz).height;
}

// Time after the detachment at which the leaf may first have dropped by `drop` metres.
fn first_time_at(variant: Variant, drop: f32) -> f32 {
    let joint = variant.joint;
    let begin = path_sample(sample_index(variant, variant.start)).place.y;
    let lowest = path_sample(sample_index(variant, joint.from_sample)).place.w;
    let level = begin - drop;
    let k = max(ceil((level - lowest) / joint.lap.y), 0.0);
    let in_lap = level - k * joint.lap.y;
    var low = select(joint.to_sample, variant.start, k == 0.0);
    var high = joint.from_sample;
    while low < high {
        let middle = (low + high) / 2u;
        if path_sample(sample_index(variant, middle)).place.w <= in_lap {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let samples = k * f32(joint.from_sample - joint.to_sample) + f32(low) - f32(variant.start) - 1.0;
    let t = max(samples, 0.0) / variant.path.rate / variant.rate;
    let soft = max(fall.soft_time, 0.0);
    return select(t + soft * 0.5, sqrt(2.0 * soft * t), t < soft * 0.5);
}

fn landing_of(leaf: LeafFall, variant: Variant) -> Landing {
    let along = variant.path.fastest_along * max(abs(variant.scale.x), abs(variant.scale.y)) * variant.rate
        + fall.wind_fastest;
    let closing = variant.path.fastest_down * variant.rate + fall.ground_steepest * along;
    var t = first_time_at(variant, leaf.origin.y - fall.ground_highest);
    var height = clearance(leaf, variant, t);
    var above = select(0.0, t, height > 0.0);
    for (var step = 0u; step < 4096u && height > 0.0; step++) {
        above = t;
        // A leaf may graze the ground by two millimetres.
        t += max((height + 2e-3) / closing, t * 1e-6);
        height = clearance(leaf, variant, t);
    }
    if leaf.origin.y <= ground_at(leaf.origin.xz).height {
        t = 0.0;
    } else if height <= 0.0 {
        var below = t;
        for (var step = 0u; step < 20u; step++) {
            let middle = 0.5 * (above + below);
            if clearance(leaf, variant, middle) > 0.0 {
                above = middle;
            } else {
                below = middle;
            }
        }
        t = below;
    }
    let place = airborne(leaf, variant, t).position;
    let ground = ground_at(place.xz);
    let heading = (unit(hash(leaf.seed, 7u)) * 2.0 - 1.0) * fall.settle_turn;
    let arriving = airborne(leaf, variant, settling(t, 1.0)).orientation;
    var up = quat_rotate(arriving, vec3(0.0, 1.0, 0.0));
    up = select(up, -up, dot(up, ground.normal) < 0.0);
    let about = vec4(ground.normal * sin(heading * 0.5), cos(heading * 0.5));
    var out: Landing;
    out.time = t;
    out.position = vec3(place.x, ground.height, place.z);
    out.orientation = normalize(quat_mul(quat_mul(about, quat_arc(up, ground.normal)), arriving));
    return out;
}

// Pose `elapsed` seconds after the detachment and before the landing.
fn falling_pose(leaf: LeafFall, variant: Variant, landing_time: f32, lying: vec4<f32>, elapsed: f32) -> Pose {
    var pose = airborne(leaf, variant, elapsed);
    let done = 1.0 - (landing_time - elapsed) / max(settle_time(landing_time), 1e-30);
    if done > 0.0 {
        let arriving = airborne(leaf, variant, settling(landing_time, 1.0)).orientation;
        let turned = airborne(leaf, variant, settling(landing_time, done)).orientation;
        let settle = quat_mul(quat_conjugate(arriving), lying);
        pose.orientation = quat_mul(turned, quat_slerp(vec4(0.0, 0.0, 0.0, 1.0), settle, smooth_step(done)));
    }
    return pose;
}
