// The sky behind everything: air, thin clouds, the sun; and before it the land beyond the terrain.

// Depth of what is behind everything.
override behind: f32 = 0.0;

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) far: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varyings {
    var out: Varyings;
    out.clip = covering_triangle(index);
    // A point on the near plane: through an infinite far plane there is none to unproject.
    out.far = frame.world_from_clip * vec4(out.clip.xy, 1.0, 1.0);
    out.clip.z = behind;
    return out;
}

// Share of a thin high cloud towards a direction.
fn cloud(direction: vec3<f32>) -> f32 {
    if frame.clouds <= 0.0 || direction.y < 0.01 {
        return 0.0;
    }
    // From a place of the noise where it makes a fair sky.
    let at = direction.xz / (direction.y + 0.08) * 1.1 + frame.cloud_drift + vec2(23.0, 14.0);
    let width = 0.004 / (direction.y * direction.y + 0.01);
    let warp = vec2(fractal_noise2(at * 0.8, width, 41u), fractal_noise2(at * 0.8 + 9.0, width, 42u));
    // Streaks along the wind aloft, torn by smaller puffs.
    let along = vec2(0.83, 0.55);
    let streak = vec2(dot(at, along) * 0.7, dot(at, vec2(-along.y, along.x)) * 2.6) + warp * 1.6;
    let sheet = fractal_noise2(streak, width * 2.0, 43u) + 0.55 * fractal_noise2(at * 2.3 + warp * 2.0, width * 2.3, 44u);
    let field = fractal_noise2(at * 0.35, width * 0.35, 45u);
    let share = smoothstep(0.34 - 0.6 * frame.clouds, 0.75 - 0.35 * frame.clouds, sheet + field + 0.12);
    return share * smoothstep(0.01, 0.16, direction.y) * 0.85;
}

// The land beyond the terrain: rows of trees and hills on cylinders about the origin, each hiding
// those behind it.
struct Land {
    color: vec3<f32>,
    covered: f32,
}

fn forest_color(key: u32) -> vec3<f32> {
    var tones = array<vec3<f32>, 5>(
        vec3(0.080, 0.078, 0.022), vec3(0.165, 0.085, 0.024), vec3(0.205, 0.125, 0.030),
        vec3(0.110, 0.060, 0.024), vec3(0.050, 0.062, 0.026),
    );
    return mix(tones[key % 5u], frame.litter * 0.45, 0.35) * (0.75 + 0.5 * unit(hash(key, 9u)));
}

// Metres along the cylinder and above the ground there, where a ray meets it.
fn on_cylinder(direction: vec3<f32>, radius: f32) -> vec3<f32> {
    let d = direction.xz;
    let a = dot(d, d);
    let b = dot(frame.eye.xz, d);
    let c = dot(frame.eye.xz, frame.eye.xz) - radius * radius;
    let root = b * b - a * c;
    // From outside of the cylinder nothing of it is drawn.
    if c > 0.0 || root < 0.0 || a < 1e-6 {
        return vec3(0.0, 1e9, 0.0);
    }
    let t = (sqrt(root) - b) / a;
    let p = frame.eye + direction * t;
    let ground = frame.backdrop.x + dot(frame.backdrop.yz, p.xz) * min(1.0, frame.backdrop.w / radius);
    return vec3(atan2(p.x, p.z) * radius, p.y - ground, t);
}

// A row of crowns of the given width about `level` metres high.
fn trees(at: vec3<f32>, width: f32, level: f32, seed: u32, pixel: f32) -> Land {
    var out = Land(vec3(0.0), 0.0);
    let sun_flat = dot(normalize(frame.sun_direction.xz + vec2(1e-4, 0.0)), vec2(cos(at.x / frame.backdrop.w), -sin(at.x / frame.backdrop.w)));
    let rough = fractal_noise2(at.xy / (width * 0.16), pixel / (width * 0.16), seed + 7u);
    let fine = fractal_noise2(at.xy / (width * 0.05), pixel / (width * 0.05), seed + 8u);
    // Three crowns deep, the farthest first.
    for (var row = 0u; row < 3u; row++) {
        let x = at.x / width + 0.37 * f32(row);
        for (var i = -1; i <= 1; i++) {
            let cell = i32(floor(x)) + i;
            let key = hash(hash(seed + row, bitcast<u32>(cell)), 3u);
            let size = 0.55 + 0.35 * unit(hash(key, 1u));
            let height = level * (0.72 + 0.42 * unit(hash(key, 2u))) * (1.0 - 0.2 * f32(row));
            let center = vec2(f32(cell) + 0.3 + 0.4 * unit(key), height - size * width * 0.9);
            var d = vec2((x - center.x) * width, at.y - center.y) / (size * width);
            d.y *= select(0.75, 1.4, d.y > 0.0 && (key & 1u) == 0u);
            // Bounded outwards, where single puffs would float over the crown.
            let r = length(d) + max(0.55 * rough + 0.3 * fine, -0.14);
            let edge = smoothstep(1.0, 1.0 - max(0.06, pixel / (size * width)), r);
            let below = smoothstep(0.0, 1.0, -d.y) * step(abs(d.x), 0.95);
            let cover = max(edge, below);
            if cover > 0.0 {
                let n = normalize(vec3(d, sqrt(max(1.0 - min(dot(d, d), 1.0), 0.05))));
                // The crown's side towards the sun, in the plane of the picture and towards the eye.
                let lit = max(0.25 + 0.9 * (n.x * sun_flat + n.y * frame.sun_direction.y) - 0.35 * rough, 0.0);
                let shade = 0.45 + 0.35 * d.y + 1.4 * rough + 1.2 * fine;
                let color = forest_color(key) * max(1.0 + 1.3 * rough + fine, 0.2);
                let light = frame.sun_color * (lit * 0.55 * clamp(shade, 0.15, 1.3) / PI)
                    + ambient(vec3(0.0, 1.0, 0.0)) * clamp(0.25 + 0.5 * shade, 0.1, 1.0);
                out.color = mix(out.color, color * light, cover);
                out.covered = max(out.covered, cover);
            }
        }
    }
    return out;
}

// A wooded ridge.
fn hills(at: vec3<f32>, level: f32, wave: f32, seed: u32, pixel: f32) -> Land {
    let ridge = level * (0.55 + 0.9 * fractal_noise2(vec2(at.x / wave, 3.0), 0.0, seed))
        + 7.0 * fractal_noise2(vec2(at.x / 26.0, 1.0), pixel / 26.0, seed + 5u);
    let edge = clamp((ridge - at.y) / max(pixel, 0.5) + 0.5, 0.0, 1.0);
    if edge <= 0.0 {
        return Land(vec3(0.0), 0.0);
    }
    // Woods climb the slope: seen from the side, crowns overlap like scales.
    let place = vec2(at.x, at.y * 3.5);
    let stand = fractal_noise2(place / 160.0, pixel / 160.0, seed + 11u);
    let crowns = fractal_noise2(place / 15.0, pixel / 15.0, seed + 12u);
    let warm = smoothstep(-0.2, 0.25, stand);
    let tone = mix(vec3(0.055, 0.062, 0.026), mix(vec3(0.155, 0.085, 0.028), frame.litter * 0.45, 0.4), warm);
    let light = frame.sun_color * (0.22 + 0.3 * crowns) * max(frame.sun_direction.y + 0.35, 0.2) / PI
        + ambient(vec3(0.0, 1.0, 0.0)) * (0.55 + 0.8 * crowns);
    return Land(tone * max(1.0 + 1.2 * crowns, 0.2) * max(light, vec3(0.0)), edge);
}

// Radii of the cylinders, times that of the nearest: three of hills, then the trees, farthest first.
fn land_radius(row: u32) -> f32 {
    var radii = array<f32, 4>(11.0, 5.0, 2.2, 1.0);
    return frame.backdrop.w * radii[min(row, 3u)];
}

fn hill_level(radius: f32) -> f32 {
    return radius * 0.035 + 8.0;
}

struct LandVaryings {
    @builtin(position) clip: vec4<f32>,
    // From the eye.
    @location(0) way: vec3<f32>,
    @location(1) @interpolate(flat) row: u32,
}

// A wall about the cylinder of a row: no larger than what may be land, since software drivers do all that a pixel
// of the sky may need wherever it is.
@vertex
fn land_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) row: u32) -> LandVaryings {
    var corners = array<vec2<f32>, 6>(
        vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0),
    );
    let corner = corners[index % 6u];
    let radius = land_radius(row);
    let angle = (f32(index / 6u) + corner.x) * 2.0 * PI / f32(LAND_SIDES);
    let flat = vec2(sin(angle), cos(angle)) * radius / cos(PI / f32(LAND_SIDES));
    let ground = frame.backdrop.x + dot(frame.backdrop.yz, flat) * min(1.0, frame.backdrop.w / radius);
    // Above the highest ridge and crown; below, whatever an eye high up may see under the horizon.
    let top = select(hill_level(radius) + 4.0, 21.0, row == 3u);
    let world = vec3(flat.x, ground + mix(-3.0 * radius, top, corner.y), flat.y);
    var out: LandVaryings;
    out.clip = frame.clip_from_world * vec4(world, 1.0);
    out.clip.z = behind * out.clip.w;
    // From outside of the cylinder nothing of it is drawn.
    if dot(frame.eye.xz, frame.eye.xz) > radius * radius {
        out.clip = vec4(0.0, 0.0, -1.0, 1.0);
    }
    out.way = world - frame.eye;
    out.row = row;
    return out;
}

fn seen_land(land: Land, direction: vec3<f32>, t: f32) -> vec4<f32> {
    return vec4(through_air(land.color, frame.eye + direction * t), land.covered);
}

@fragment
fn distant_hills(in: LandVaryings) -> @location(0) vec4<f32> {
    let direction = normalize(in.way);
    let radius = land_radius(in.row);
    let at = on_cylinder(direction, radius);
    let land = hills(at, hill_level(radius), radius * 0.55, 60u + 20u * in.row, at.z * length(dpdy(direction)));
    return seen_land(land, direction, at.z);
}

@fragment
fn distant_trees(in: LandVaryings) -> @location(0) vec4<f32> {
    let direction = normalize(in.way);
    let at = on_cylinder(direction, land_radius(in.row));
    return seen_land(trees(at, 9.0, 16.0, 130u, at.z * length(dpdy(direction))), direction, at.z);
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let direction = normalize(in.far.xyz / in.far.w - frame.eye);
    let cosine = dot(direction, frame.sun_direction);
    var color = sky_radiance(direction);
    if !has(SKY_PICTURE) {
        let disc = smoothstep(0.99985, 0.99992, cosine) * 40.0;
        let thin = cloud(direction);
        // Ice scatters forwards: bright about the sun.
        let lit = frame.sun_color * (0.05 + 0.12 * pow(max(cosine, 0.0), 12.0)) + ambient(vec3(0.0, 1.0, 0.0)) * 0.55;
        color = mix(color + frame.sun_color * disc * 0.5, lit + 0.35 * color, thin);
    }
    // Everything else has alpha.
    return vec4(color, select(1.0, 0.0, has(TRANSPARENT_SKY)));
}
