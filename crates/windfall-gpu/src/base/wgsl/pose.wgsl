// Where a falling leaf is, as in windfall_core::path (playback, landing, variation), of
// windfall_core::wind and of windfall_core::forest::Terrain.

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

// The product with a turn about Y, of which the sine and cosine of half the angle are given.
fn quat_turn(half_angle: vec2<f32>, q: vec4<f32>) -> vec4<f32> {
    let s = half_angle.x;
    let c = half_angle.y;
    return vec4(c * q.x + s * q.z, c * q.y + s * q.w, c * q.z - s * q.x, c * q.w - s * q.y);
}

// x and z turned about Y, of which the sine and cosine of half the angle are given.
fn turn_along(half_angle: vec2<f32>, v: vec2<f32>) -> vec2<f32> {
    let s = 2.0 * half_angle.x * half_angle.y;
    let c = 1.0 - 2.0 * half_angle.x * half_angle.x;
    return vec2(c * v.x + s * v.y, c * v.y - s * v.x);
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

// A number of turns, whole ones dropped.
fn fixed_turns(turns: f32) -> u32 {
    return bitcast<u32>(i32((turns - floor(turns + 0.5)) * 4294967296.0));
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

// Seconds from a time, as detach times are, to the moment of the frame.
fn since(time: f32) -> f32 {
    return (fall.time - time) + fall.time_low;
}

// The gusts at a moment, at a tree where they come `late` seconds late: what displacements are sums of,
// without (x and y) and with the lag of the leaf.
fn gusts_at(late: f32, time: f32) -> vec4<f32> {
    let start = time - WIND_PERIOD * floor(time / WIND_PERIOD);
    let a = 1.0 / max(fall.wind_response, 1e-4);
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let gust = fall.gusts[i]; // amplitude x and z, cycles, phase
        let omega = 2.0 * PI * gust.z / WIND_PERIOD;
        let at = sin_cos_turns(fixed_turns(gust.z * ((start - late) / WIND_PERIOD) + gust.w));
        sum += gust.xyxy * vec4(
            vec2(at.y / omega),
            vec2((a * at.x + omega * at.y) / (a * a + omega * omega)),
        );
    }
    return sum;
}

// What the steady wind and the gusts of the moment add; the gusts at the detachment are constant.
fn wind_since(elapsed: f32, gusts: vec4<f32>) -> vec2<f32> {
    let lag = max(fall.wind_response, 1e-4);
    let fade = exp(max(-elapsed / lag, -60.0));
    return fall.wind_mean * (elapsed - lag * (1.0 - fade)) - gusts.xy + fade * gusts.zw;
}

fn wind_at_detachment(late: f32, detach_time: f32) -> vec2<f32> {
    let gusts = gusts_at(late, detach_time);
    return gusts.xy - gusts.zw;
}

fn wind_displacement(late: f32, detach_time: f32, elapsed: f32) -> vec2<f32> {
    let start = detach_time - WIND_PERIOD * floor(detach_time / WIND_PERIOD);
    let part = elapsed - WIND_PERIOD * floor(elapsed / WIND_PERIOD);
    return wind_at_detachment(late, detach_time) + wind_since(elapsed, gusts_at(late, start + part));
}

fn wind_late(tree: vec2<f32>) -> f32 {
    return dot(fall.wind_travel, tree) * fall.wind_slowness;
}

// --- one leaf's share of variety ----------------------------------------------------------------

struct LeafFall {
    origin: vec3<f32>,
    twig: vec4<f32>,
    seed: u32,
    // windfall_core::path::Variant, as one number.
    variant: u32,
    detach_time: f32,
    // Seconds by which gusts come late at its tree.
    late: f32,
}

struct Variant {
    flight: u32,
    // Turn about Y, 2^-32 turns.
    yaw: u32,
    scale: vec2<f32>,
    rate: f32,
}

fn pick(u: f32, n: u32) -> u32 {
    return min(u32(u * f32(n)), max(n, 1u) - 1u);
}

fn positive_mod(a: f32, b: f32) -> f32 {
    return a - b * floor(a / b);
}

// Factors of rotation, scale and starting point: windfall_core::path::Edition.
fn paper_factors() -> vec3<f32> {
    return select(PAPER_2008, PAPER_2007, fall.paper_variation == 2u);
}

// Draws a leaf's variant.
fn draw_variant(seed: u32, path_group: u32, origin: vec3<f32>) -> u32 {
    let flights = table(fall.group_table + path_group); // first, how many, of those plain
    if fall.paper_variation != 0u {
        let starts = max(flights.z, 2u) - 1u;
        let start = pick(positive_mod(origin.y * origin.x * paper_factors().z, f32(starts)) / f32(starts), starts);
        return flights.x + min(start, flights.z - 1u);
    }
    return (flights.x + pick(unit(hash(seed, 1u)), flights.y)) | (hash(seed, 2u) << 14u);
}

fn variant_of(word: u32, origin: vec3<f32>) -> Variant {
    var out: Variant;
    out.flight = word & 0x3fffu;
    out.yaw = ((word >> 14u) & 255u) << 24u;
    let steps = (vec2<f32>((vec2(word) >> vec2(22u, 27u)) & vec2(31u)) + 0.5) / 32.0;
    out.scale = vec2(fall.scale_low + (fall.scale_high - fall.scale_low) * steps.x);
    out.rate = fall.rate_low + (fall.rate_high - fall.rate_low) * steps.y;
    if fall.paper_variation != 0u {
        let factors = paper_factors();
        out.yaw = fixed_turns(positive_mod(origin.x * origin.y * origin.z * factors.x, 360.0) / 360.0);
        out.scale = vec2(
            positive_mod(origin.z * origin.y * factors.y, 3.0),
            positive_mod(origin.x * origin.y * factors.y, 3.0),
        );
        out.rate = 1.0;
    }
    return out;
}

// --- the path -----------------------------------------------------------------------------------

struct CurvePoint {
    position: vec3<f32>,
    orientation: vec4<f32>,
}

// Catmull-Rom through four samples, displacement and quaternion alike.
fn curve(flight: Flight, u: f32) -> CurvePoint {
    let i = min(u32(u), flight.from_sample - 1u);
    let x = u - f32(i);
    let at = flight.first_sample + i;
    let s0 = path_sample(at - select(1u, 0u, i == 0u));
    let s1 = path_sample(at);
    let s2 = path_sample(at + 1u);
    let s3 = path_sample(at + 2u);
    let x2 = x * x;
    let x3 = x2 * x;
    let w0 = 0.5 * (-x + 2.0 * x2 - x3);
    let w1 = 0.5 * (2.0 - 5.0 * x2 + 3.0 * x3);
    let w2 = 0.5 * (x + 4.0 * x2 - 3.0 * x3);
    let w3 = 0.5 * (-x2 + x3);
    var out: CurvePoint;
    out.position = w0 * s0.place + w1 * s1.place + w2 * s2.place + w3 * s3.place;
    let q = w0 * s0.orientation + w1 * s1.orientation + w2 * s2.orientation + w3 * s3.orientation;
    out.orientation = q * inverseSqrt(max(dot(q, q), 1e-6));
    return out;
}

fn path_time(variant: Variant, elapsed: f32) -> f32 {
    let soft = fall.soft_time;
    let t = select(elapsed - max(soft, 0.0) * 0.5, elapsed * elapsed / (2.0 * soft), elapsed < soft);
    return t * variant.rate;
}

// The path alone, endless: from the twig, in the world's directions.
struct Way {
    displacement: vec3<f32>,
    orientation: vec4<f32>,
    lap: u32,
    // Sample within the lap, and samples since laps began.
    local: f32,
    beyond: f32,
}

fn way(flight: Flight, variant: Variant, elapsed: f32) -> Way {
    let u = f32(flight.start) + path_time(variant, elapsed) * flight.rate;
    let lap_samples = f32(flight.from_sample - flight.to_sample);
    var out: Way;
    out.beyond = u - f32(flight.from_sample);
    let full = floor(max(out.beyond, 0.0) / lap_samples);
    let rest = clamp(out.beyond - full * lap_samples, 0.0, lap_samples);
    out.lap = select(0u, u32(full) + 1u, out.beyond >= 0.0);
    out.local = select(u, f32(flight.to_sample) + rest, out.beyond >= 0.0);
    let at = curve(flight, out.local);
    // The laps before are a geometric series of turns of one lap's displacement: the sine of k h over
    // that of h, which the table has divided by.
    let turn = sin_cos_turns(out.lap * flight.half_turn);
    let sum = turn.x * vec2(
        flight.lap.x * turn.y + flight.lap.z * turn.x,
        flight.lap.z * turn.y - flight.lap.x * turn.x,
    );
    let along = (flight.lead.xz + sum + turn_along(turn, at.position.xz)) * variant.scale;
    let yaw = sin_cos_turns(variant.yaw >> 1u);
    let turned = turn_along(yaw, along);
    let down = flight.lead.y + flight.lap.y * f32(out.lap) + at.position.y;
    out.displacement = vec3(turned.x, down, turned.y);
    let both = vec2(yaw.x * turn.y + yaw.y * turn.x, yaw.y * turn.y - yaw.x * turn.x);
    out.orientation = quat_turn(both, at.orientation);
    return out;
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
    let flight = flight_of(variant.flight);
    let free = way(flight, variant, elapsed);
    let blown = wind_displacement(leaf.late, leaf.detach_time, elapsed);
    let lows = flight_lows(variant.flight);
    let i = min(u32(free.local), flight.from_sample - 1u);
    let low = path_low(flight.first_sample + i);
    var drop = lows.x - low - (path_low(flight.first_sample + i + 1u) - low) * (free.local - f32(i));
    if free.lap > 0u {
        drop = lows.x - lows.y - flight.lap.y * free.beyond / f32(flight.from_sample - flight.to_sample);
    }
    var out: Pose;
    out.position = leaf.origin + free.displacement + vec3(blown.x, 0.0, blown.y);
    out.orientation = free.orientation;
    out.lap = free.lap;
    out.bend = select(1.0, smooth_step(drop / fall.soft_drop), fall.soft_drop > 0.0);
    if out.bend < 1.0 {
        let begin = path_sample(flight.first_sample + flight.start).orientation;
        let first = quat_turn(sin_cos_turns(variant.yaw >> 1u), normalize(begin));
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
fn first_time_at(flight: Flight, variant: Variant, drop: f32) -> f32 {
    let level = -flight.lead.y - drop;
    let lowest = path_low(flight.first_sample + flight.from_sample);
    let k = max(ceil((level - lowest) / flight.lap.y), 0.0);
    let in_lap = level - k * flight.lap.y;
    var low = select(flight.to_sample, flight.start, k == 0.0);
    var high = flight.from_sample;
    while low < high {
        let middle = (low + high) / 2u;
        if path_low(flight.first_sample + middle) <= in_lap {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let samples = k * f32(flight.from_sample - flight.to_sample) + f32(low) - f32(flight.start) - 1.0;
    let t = max(samples, 0.0) / flight.rate / variant.rate;
    let soft = max(fall.soft_time, 0.0);
    return select(t + soft * 0.5, sqrt(2.0 * soft * t), t < soft * 0.5);
}

// When the leaf first meets the ground, seconds after the detachment.
fn landing_time(leaf: LeafFall, variant: Variant) -> f32 {
    let flight = flight_of(variant.flight);
    let fastest = flight_speeds(variant.flight); // down, along
    let along = fastest.y * max(abs(variant.scale.x), abs(variant.scale.y)) * variant.rate
        + fall.wind_fastest;
    let closing = fastest.x * variant.rate + fall.ground_steepest * along;
    var t = first_time_at(flight, variant, leaf.origin.y - fall.ground_highest);
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
    return t;
}

// Where and how a leaf lies that meets the ground at `time`.
fn landing_at(leaf: LeafFall, variant: Variant, time: f32) -> Landing {
    let place = airborne(leaf, variant, time).position;
    let ground = ground_at(place.xz);
    let heading = (unit(hash(leaf.seed, 7u)) * 2.0 - 1.0) * fall.settle_turn;
    let arriving = airborne(leaf, variant, settling(time, 1.0)).orientation;
    var up = quat_rotate(arriving, vec3(0.0, 1.0, 0.0));
    up = select(up, -up, dot(up, ground.normal) < 0.0);
    let about = vec4(ground.normal * sin(heading * 0.5), cos(heading * 0.5));
    var out: Landing;
    out.time = time;
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
