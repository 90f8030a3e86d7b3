// The light of the sky: the table of its radiance, the sun's irradiance and the ambient light.
//
// Hillaire's model of the atmosphere (EGSR 2020) and the projection onto spherical harmonics as
// windfall_core::light computes them. That is the reference, and documents the formulas. Lengths are
// kilometres, scattering and extinction 1/km. SkyInput, SkyUniform and all constants come from Rust.

// A table over the height (rows) and the cosine of the sun with the vertical (columns).
struct Table {
    first: u32,
    columns: u32,
    rows: u32,
}

const TRANSMITTANCE = Table(0u, TRANSMITTANCE_COLUMNS, TRANSMITTANCE_ROWS);
const MULTIPLE_FIRST: u32 = TRANSMITTANCE_COLUMNS * TRANSMITTANCE_ROWS;
const MULTIPLE = Table(MULTIPLE_FIRST, MULTIPLE_COLUMNS, MULTIPLE_ROWS);
const RADIANCE_FIRST: u32 = MULTIPLE_FIRST + MULTIPLE_COLUMNS * MULTIPLE_ROWS;

@group(0) @binding(0) var<uniform> input: SkyInput;
// SkyInput.air of the tables as they are; zero before the first.
@group(0) @binding(1) var<storage, read> made_for: vec4<f32>;
// Transmittance, multiple scattering, radiance of the sky.
@group(0) @binding(2) var<storage, read_write> tables: array<vec3<f32>, RADIANCE_FIRST + SIDE * SIDE>;
@group(0) @binding(3) var sky_table: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var<storage, read_write> light: SkyUniform;

// Whether transmittance and multiple scattering are not yet those of this air.
fn air_changed() -> bool {
    return any(made_for.xw != input.air.xw);
}

// Whether the radiance is not yet that of this air and height of the sun.
fn sky_changed() -> bool {
    return any(made_for != input.air);
}

struct Medium {
    rayleigh: vec3<f32>,
    mie: f32,
    extinction: vec3<f32>,
}

fn medium_at(height: f32) -> Medium {
    let rayleigh = RAYLEIGH * exp(-height / RAYLEIGH_HEIGHT);
    let haze = input.air.x * exp(-height / MIE_HEIGHT);
    let ozone = OZONE * max(1.0 - abs(height - OZONE_HEIGHT) / OZONE_REACH, 0.0);
    return Medium(rayleigh, haze * MIE_ALBEDO, rayleigh + haze + ozone);
}

// A ray from a height above the ground.
struct Ray {
    height: f32,
    // With the vertical.
    cosine: f32,
}

// Squares of radii are about 4e7, where floats are 4 apart. Their differences are computed from heights
// instead, so that the results do not depend on how a device rounds.

// Square of the half chord that the sphere at a height cuts out of a ray's line; negative if the line
// misses it.
fn half_chord2(ray: Ray, sphere: f32) -> f32 {
    let along = (GROUND + ray.height) * ray.cosine;
    return along * along + (sphere - ray.height) * (2.0 * GROUND + sphere + ray.height);
}

fn ground_ahead(ray: Ray) -> bool {
    return ray.cosine < 0.0 && half_chord2(ray, 0.0) > 0.0;
}

// Distance to the top of the air.
fn top_distance(ray: Ray) -> f32 {
    return max(sqrt(max(half_chord2(ray, TOP - GROUND), 0.0)) - (GROUND + ray.height) * ray.cosine, 0.0);
}

// Distance to the ground, if it is ahead.
fn ground_distance(ray: Ray) -> f32 {
    let nearest = -(GROUND + ray.height) * ray.cosine;
    return ray.height * (2.0 * GROUND + ray.height) / (nearest + sqrt(max(half_chord2(ray, 0.0), 0.0)));
}

// Height after a distance.
fn height_after(ray: Ray, distance: f32) -> f32 {
    // Difference of the squares of the radii there and on the ground.
    let rise = ray.height * (2.0 * GROUND + ray.height)
        + distance * (distance + 2.0 * (GROUND + ray.height) * ray.cosine);
    return max(rise / (GROUND + sqrt(max(GROUND * GROUND + rise, 0.0))), 0.0);
}

// Where step i of a ray ends, as a share of its length: steps grow along the way, since the air is
// dense at its beginning.
fn step_end(i: u32, steps: u32) -> f32 {
    let share = f32(i + 1u) / f32(steps);
    return share * share;
}

// Share of the light that passes to the top of the air along a ray.
fn transmittance_along(ray: Ray) -> vec3<f32> {
    if ground_ahead(ray) {
        return vec3(0.0);
    }
    let length = top_distance(ray);
    var depth = vec3(0.0);
    var before = 0.0;
    for (var i = 0u; i < TRANSMITTANCE_STEPS; i++) {
        let after = length * step_end(i, TRANSMITTANCE_STEPS);
        depth += medium_at(height_after(ray, 0.5 * (before + after))).extinction * (after - before);
        before = after;
    }
    return exp(-depth);
}

// Height and cosine of an entry of a table: dense near the ground and near the horizon.
fn entry_of(table: Table, index: u32) -> Ray {
    let x = f32(index % table.columns) / f32(table.columns - 1u);
    let y = f32(index / table.columns) / f32(table.rows - 1u);
    let s = 2.0 * x - 1.0;
    return Ray(y * y * (TOP - GROUND), s * abs(s));
}

// Bilinear interpolation.
fn look_up(table: Table, height: f32, cosine: f32) -> vec3<f32> {
    let x = (0.5 * sign(cosine) * sqrt(abs(cosine)) + 0.5) * f32(table.columns - 1u);
    let y = sqrt(clamp(height / (TOP - GROUND), 0.0, 1.0)) * f32(table.rows - 1u);
    let i = min(u32(x), table.columns - 2u);
    let j = min(u32(y), table.rows - 2u);
    let at = table.first + j * table.columns + i;
    let fx = x - f32(i);
    return mix(
        mix(tables[at], tables[at + 1u], fx),
        mix(tables[at + table.columns], tables[at + table.columns + 1u], fx),
        y - f32(j),
    );
}

// Cosine of the sun with the vertical after a distance along a ray: the sun's direction is fixed, the
// vertical turns. `sun` is the cosine where the ray begins, `towards` that between ray and sun.
fn sun_after(ray: Ray, sun: f32, towards: f32, distance: f32, height: f32) -> f32 {
    return clamp(((GROUND + ray.height) * sun + distance * towards) / (GROUND + height), -1.0, 1.0);
}

@compute @workgroup_size(BLOCK)
fn transmittance(@builtin(global_invocation_id) id: vec3<u32>) {
    if air_changed() && id.x < MULTIPLE_FIRST {
        tables[id.x] = transmittance_along(entry_of(TRANSMITTANCE, id.x));
    }
}

// For each ray: radiance for a sun of irradiance 1, and the share of radiance 1 from everywhere that is
// scattered into the ray.
var<workgroup> ray_radiance: array<vec3<f32>, MULTIPLE_SQRT_RAYS * MULTIPLE_SQRT_RAYS>;
var<workgroup> ray_share: array<vec3<f32>, MULTIPLE_SQRT_RAYS * MULTIPLE_SQRT_RAYS>;

// All orders of scattering above the first (equations 5 to 10), with isotropic phase functions. A
// workgroup per entry, an invocation per ray.
@compute @workgroup_size(MULTIPLE_SQRT_RAYS, MULTIPLE_SQRT_RAYS)
fn multiple(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    if !air_changed() {
        return;
    }
    let entry = entry_of(MULTIPLE, group.x);
    let sun = entry.cosine;
    let y = 1.0 - f32(2u * id.y + 1u) / f32(MULTIPLE_SQRT_RAYS);
    let across = sqrt((1.0 - y * y) * max(1.0 - sun * sun, 0.0));
    // Half of the circle: it is symmetric.
    let towards = y * sun + across * cos(PI * (f32(id.x) + 0.5) / f32(MULTIPLE_SQRT_RAYS));
    let ray = Ray(entry.height, y);
    let ground = ground_ahead(ray);
    let length = select(top_distance(ray), ground_distance(ray), ground);
    var radiance = vec3(0.0);
    var share = vec3(0.0);
    var through = vec3(1.0);
    var before = 0.0;
    for (var i = 0u; i < MULTIPLE_STEPS; i++) {
        let after = length * step_end(i, MULTIPLE_STEPS);
        let middle = 0.5 * (before + after);
        let height = height_after(ray, middle);
        let medium = medium_at(height);
        let kept = exp(-medium.extinction * (after - before));
        let scattered = through * (1.0 - kept) / max(medium.extinction, vec3(1e-9)) * (medium.rayleigh + medium.mie);
        let cosine = sun_after(ray, sun, towards, middle, height);
        radiance += scattered * look_up(TRANSMITTANCE, height, cosine) / (4.0 * PI);
        share += scattered;
        through *= kept;
        before = after;
    }
    if ground {
        let up = sun_after(ray, sun, towards, length, 0.0);
        radiance += through * look_up(TRANSMITTANCE, 0.0, up) * (max(up, 0.0) * GROUND_ALBEDO / PI);
    }
    ray_radiance[local] = radiance;
    ray_share[local] = share;
    workgroupBarrier();
    if local == 0u {
        const RAYS = MULTIPLE_SQRT_RAYS * MULTIPLE_SQRT_RAYS;
        var second = vec3(0.0);
        var all = vec3(0.0);
        for (var i = 0u; i < RAYS; i++) {
            second += ray_radiance[i];
            all += ray_share[i];
        }
        let left = max(1.0 - all / f32(RAYS), vec3(MULTIPLE_LEAST));
        tables[MULTIPLE_FIRST + group.x] = second / f32(RAYS) / left;
    }
}

fn cornette_shanks(cosine: f32) -> f32 {
    const G = MIE_FORWARD;
    let below = 1.0 + G * G - 2.0 * G * cosine;
    return 3.0 / (8.0 * PI) * (1.0 - G * G) * (1.0 + cosine * cosine) / ((2.0 + G * G) * below * sqrt(below));
}

// The steps of a row's rays, which all rise alike. Optical depth; scattering by air and by haze that
// reaches the eye, before the phase functions; in w the height and the distance.
var<workgroup> step_depth: array<vec3<f32>, SKY_STEPS>;
var<workgroup> step_rayleigh: array<vec4<f32>, SKY_STEPS>;
var<workgroup> step_mie: array<vec4<f32>, SKY_STEPS>;

// Radiance of the sky: a workgroup per row of the table, an invocation per texel. The first invocations
// also compute a step of the row's rays each.
@compute @workgroup_size(SIDE)
fn radiance(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    if !sky_changed() {
        return;
    }
    let v = f32(group.x) / f32(SIDE - 1u);
    // Rises, so that the ground is never ahead.
    let ray = Ray(EYE, clamp(v * v, LOWEST_VIEW, 1.0));
    let length = top_distance(ray);
    var before = 0.0;
    if local > 0u {
        before = length * step_end(local - 1u, SKY_STEPS);
    }
    let after = length * step_end(local, SKY_STEPS);
    let middle = 0.5 * (before + after);
    let height = height_after(ray, middle);
    let medium = medium_at(height);
    let depth = medium.extinction * (after - before);
    if local < SKY_STEPS {
        step_depth[local] = depth;
    }
    workgroupBarrier();
    if local < SKY_STEPS {
        var passed = vec3(0.0);
        for (var i = 0u; i < local; i++) {
            passed += step_depth[i];
        }
        let weight = exp(-passed) * (1.0 - exp(-depth)) / max(medium.extinction, vec3(1e-9));
        step_rayleigh[local] = vec4(weight * medium.rayleigh, height);
        step_mie[local] = vec4(weight * medium.mie, middle);
    }
    workgroupBarrier();
    let u = f32(local) / f32(SIDE - 1u);
    let sun = input.air.y;
    let across = sqrt(max(1.0 - ray.cosine * ray.cosine, 0.0)) * input.air.z;
    let towards = clamp(ray.cosine * sun + across * (1.0 - 2.0 * u * u), -1.0, 1.0);
    let rayleigh_phase = 3.0 / (16.0 * PI) * (1.0 + towards * towards);
    let mie_phase = cornette_shanks(towards);
    var sum = vec3(0.0);
    for (var i = 0u; i < SKY_STEPS; i++) {
        let rayleigh = step_rayleigh[i];
        let mie = step_mie[i];
        let cosine = sun_after(ray, sun, towards, mie.w, rayleigh.w);
        sum += (rayleigh.xyz * rayleigh_phase + mie.xyz * mie_phase) * look_up(TRANSMITTANCE, rayleigh.w, cosine)
            + (rayleigh.xyz + mie.xyz) * look_up(MULTIPLE, rayleigh.w, cosine);
    }
    // At most about 60, towards the sun in haze: half floats reach 65504.
    sum *= SOLAR;
    tables[RADIANCE_FIRST + group.x * SIDE + local] = sum;
    // Rounded here: some drivers cut the digits off that a half has no room for, and skies get darker.
    let rounded = vec3(unpack2x16float(pack2x16float(sum.xy)), unpack2x16float(pack2x16float(vec2(sum.z, 0.0))).x);
    textureStore(sky_table, vec2(local, group.x), vec4(rounded, 1.0));
}

// Radiance towards a direction of the upper half.
fn radiance_towards(direction: vec3<f32>) -> vec3<f32> {
    let flat = direction.xz / max(length(direction.xz), 1e-9);
    let place = sqrt(clamp(vec2(0.5 - 0.5 * dot(flat, input.heading), direction.y), vec2(0.0), vec2(1.0)));
    let at = place * f32(SIDE - 1u);
    let corner = min(vec2<u32>(at), vec2(SIDE - 2u));
    let f = at - vec2<f32>(corner);
    let first = RADIANCE_FIRST + corner.y * SIDE + corner.x;
    return mix(
        mix(tables[first], tables[first + 1u], f.x),
        mix(tables[first + SIDE], tables[first + SIDE + 1u], f.x),
        f.y,
    );
}

// Irradiance over pi on level ground, from the harmonics that are not zero for its normal.
fn irradiance_above(even: vec3<f32>, y: vec3<f32>, z2: vec3<f32>, x2_y2: vec3<f32>) -> vec3<f32> {
    return max(even + y - z2 - x2_y2, vec3(0.0));
}

// As many invocations as directions in a ring.
const PROJECTORS: u32 = 2u * RINGS;
var<workgroup> sums: array<array<vec3<f32>, 9>, PROJECTORS>;
// Harmonics of the model's upper half.
var<workgroup> upper: array<vec3<f32>, 9>;

// Sun and ambient light: one workgroup, an invocation per azimuth, then one per harmonic.
@compute @workgroup_size(PROJECTORS)
fn project(@builtin(local_invocation_index) local: u32) {
    // From -pi to pi, where WGSL bounds the error of sines.
    let turn = 2.0 * PI * ((f32(local) + 0.5) / f32(PROJECTORS) - 0.5);
    let c = cos(turn);
    let s = sin(turn);
    var sum: array<vec3<f32>, 9>;
    // Rings from the zenith down to the horizon.
    for (var i = 0u; i < RINGS / 2u; i++) {
        let y = 1.0 - f32(2u * i + 1u) / f32(RINGS);
        let across = sqrt(1.0 - y * y);
        let d = vec3(across * c, y, across * s);
        let arriving = radiance_towards(d) * (4.0 * PI / f32(RINGS * PROJECTORS));
        sum[0] += arriving;
        sum[1] += arriving * d.y;
        sum[2] += arriving * d.z;
        sum[3] += arriving * d.x;
        sum[4] += arriving * (d.x * d.y);
        sum[5] += arriving * (d.y * d.z);
        sum[6] += arriving * (3.0 * d.z * d.z - 1.0);
        sum[7] += arriving * (d.x * d.z);
        sum[8] += arriving * (d.x * d.x - d.y * d.y);
    }
    sums[local] = sum;
    workgroupBarrier();
    if local < 9u {
        var all = vec3(0.0);
        for (var i = 0u; i < PROJECTORS; i++) {
            all += sums[i][local];
        }
        var factors = FACTORS;
        upper[local] = all * factors[local];
    }
    workgroupBarrier();
    if local < 9u {
        let model = irradiance_above(upper[0], upper[1], upper[6], upper[8]);
        // The picture takes the model's brightness. No branch: Mesa may compile a shader anew for each value
        // of a uniform that it branches on.
        let pictured = input.picture_mean > 0.0;
        let scale = select(1.0, dot(model, LUMINANCE) / input.picture_mean, pictured);
        let picture = irradiance_above(
            input.picture[0].rgb, input.picture[1].rgb, input.picture[6].rgb, input.picture[8].rgb,
        );
        let above = select(model, picture * scale, pictured);
        let sun = transmittance_along(Ray(EYE, max(input.air.y, LOWEST_SUN))) * SOLAR;
        let arriving = above + sun * (max(input.air.y, 0.0) * SUNLIT / PI);
        let sky = select(upper[local], input.picture[local].rgb * scale, pictured);
        var lower = LOWER_HALF;
        light.ambient[local] = vec4(sky + SOIL * arriving * lower[local], 0.0);
        if local == 0u {
            light.sun_color = sun;
            light.sky_scale = scale;
        }
    }
}
