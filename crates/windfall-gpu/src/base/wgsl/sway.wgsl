// Trees in the wind: windfall_core::sway is the reference.

// Sine of an angle in turns, to a thousandth: two parabolas, corrected once.
fn wave(turns: f32) -> f32 {
    let x = turns - floor(turns + 0.5);
    let y = 8.0 * x - 16.0 * x * abs(x);
    return y + 0.225 * (y * abs(y) - y);
}

fn wind_at(place: vec3<f32>) -> vec2<f32> {
    let late = dot(frame.wind_travel, place.xz) * frame.wind_slowness;
    var v = frame.wind_mean;
    for (var i = 0u; i < 4u; i++) {
        let gust = frame.gusts[i]; // amplitude x and z, cycles, phase
        let turns = gust.z * ((frame.time - late) / WIND_PERIOD) + gust.w;
        v += gust.xy * wave(turns);
    }
    return v;
}

fn swing(place: vec3<f32>, waves: vec3<f32>, rate: f32) -> f32 {
    let turns = dot(place, waves) + frame.time * rate;
    return wave(turns);
}

// The whole tree leans by the wind's pressure.
fn lean_of(wind: vec2<f32>, high: f32) -> vec2<f32> {
    let speed = length(wind);
    return wind * min(speed * 1.5e-4 * high * sqrt(high), 0.03 * high / max(speed, 1e-3));
}

// How a leaf that hangs at `rest` has turned about its place, as a quaternion; `share` of it.
fn flutter(rest: vec3<f32>, share: f32) -> vec4<f32> {
    return flutter_in(wind_at(rest), rest, share);
}

fn flutter_in(wind: vec2<f32>, rest: vec3<f32>, share: f32) -> vec4<f32> {
    let speed = min(length(wind), 8.0);
    let x = swing(rest, vec3(2.3, 1.9, -2.9), 3.15625);
    let y = swing(rest, vec3(1.7, -3.1, 2.2), 2.84375);
    let z = swing(rest, vec3(-2.7, 2.1, 2.5), 3.71875);
    let turned = vec3(x, 0.6 * y, z) * (0.06 * speed * frame.sway * share);
    return normalize(vec4(turned * 0.5, 1.0));
}

// How far a part of a tree whose foot is at height `foot` has moved from its place at rest, metres.
fn sway(rest: vec3<f32>, foot: f32) -> vec3<f32> {
    if frame.sway == 0.0 {
        return vec3(0.0);
    }
    return sway_in(wind_at(rest), rest, foot);
}

fn sway_in(wind: vec2<f32>, rest: vec3<f32>, foot: f32) -> vec3<f32> {
    let high = max(rest.y - foot, 0.0);
    let speed = length(wind);
    let lean = lean_of(wind, high);
    // Limbs rock about it, twigs tremble: each part in its own time.
    let free = high / (high + 4.0);
    let rock = 0.014 * free * min(speed, 8.0);
    let tremble = 0.0035 * free * min(speed, 8.0);
    let x = rock * swing(rest, vec3(0.13, 0.07, 0.11), 0.34375) + tremble * swing(rest, vec3(0.9, 0.7, -0.8), 2.28125);
    let y = 0.6 * rock * swing(rest, vec3(-0.17, 0.05, 0.19), 0.46875) + tremble * swing(rest, vec3(-0.8, 0.9, 0.9), 2.71875);
    let z = rock * swing(rest, vec3(0.09, -0.08, 0.15), 0.40625) + tremble * swing(rest, vec3(0.7, -0.9, 0.8), 2.53125);
    return frame.sway * (vec3(lean.x, 0.0, lean.y) + vec3(x, y, z));
}

// Both, of a leaf on its twig.
struct Swayed {
    moved: vec3<f32>,
    turned: vec4<f32>,
}

fn sway_and_flutter(rest: vec3<f32>, foot: f32) -> Swayed {
    let wind = wind_at(rest);
    return Swayed(sway_in(wind, rest, foot), flutter_in(wind, rest, 1.0));
}
