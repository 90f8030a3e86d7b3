// Trunks and branches.

@group(1) @binding(0) var<uniform> model: Model;
@group(1) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(1) @binding(2) var pictures: texture_2d_array<f32>;
@group(1) @binding(3) var picture_sampler: sampler;

struct WoodVertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) material: u32,
    // Radius of the branch, and the error about which it vanishes, metres of the tree.
    @location(4) branch: vec2<f32>,
}

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) shade: f32,
    @location(4) @interpolate(flat) material: u32,
    // Metres above the foot.
    @location(5) high: f32,
}

// Coarse levels are drawn far away: of the wind no more than that trees lean is seen there. Settled when the
// pipeline is made, since software drivers run both sides of every branch.
override far: bool = false;
// Whether no more than the colours of patches is seen of the bark, far away and on twigs.
override plain: bool = false;

@vertex
fn vertex(in: WoodVertex, tree: Tree) -> Varyings {
    var out: Varyings;
    // Lists of wood have there how far it may be from its place.
    let position = in.position + in.normal.xyz * widening(in.branch, tree.fade_growth.z);
    if far {
        out.world = world_from_far_tree(tree, position);
    } else {
        out.world = world_from_tree(tree, position);
    }
    out.clip = frame.clip_from_world * vec4(out.world, 1.0);
    out.normal = turn(tree, in.normal.xyz);
    out.uv = in.uv;
    // Inside the crown leaves take the light.
    let inside = length((in.position - model.crown_center) / model.crown_extent);
    out.shade = select(1.0, mix(0.4, 1.0, smoothstep(0.3, 1.1, inside)), model.leaf_count > 0u);
    out.material = in.material;
    out.high = in.position.y * tree.position_scale.w;
    return out;
}

// What bark is at a place.
struct Bark {
    // Relief, 0 in the grooves to 1 on the ridges.
    height: f32,
    // Share of the groove's colour.
    dark: f32,
}

// Distances to the nearest and second nearest of points jittered about a grid (Worley, "A Cellular
// Texture Basis Function", SIGGRAPH 1996).
fn cells(at: vec2<f32>, seed: u32) -> vec2<f32> {
    let cell = floor(at);
    var nearest = vec2(9.0);
    for (var j = -1; j <= 1; j++) {
        for (var i = -1; i <= 1; i++) {
            let c = vec2<u32>(vec2<i32>(cell) + vec2(i, j));
            let key = hash(hash(seed, c.x), c.y);
            let d = cell + vec2(f32(i), f32(j)) + vec2(unit(key), unit(hash(key, 1u))) - at;
            let far = length(d);
            nearest = select(vec2(nearest.x, min(nearest.y, far)), vec2(far, nearest.x), far < nearest.x);
        }
    }
    return nearest;
}

// uv in metres around and along.
fn bark(surface: Surface, uv: vec2<f32>, metres: f32, high: f32) -> Bark {
    let p = uv / surface.scale;
    let pixel = metres / surface.scale;
    let coarse = 1.0 - smoothstep(0.18, 0.6, pixel);
    let fine = fractal_noise2(p * vec2(7.0, 3.0), pixel * 6.0, 8u);
    let patchy = fractal_noise2(p * 0.35, pixel * 0.35, 9u);
    if surface.pattern == 4u {
        // Paper: dark lenticels, wide and thin, and black scars.
        let lines = fractal_noise2(p * vec2(1.6, 12.0), pixel * 9.0, 3u);
        let lenticel = smoothstep(0.19, 0.28, lines) * coarse;
        let scars = value_noise2(p * vec2(0.5, 0.8) + patchy, 4u) + 0.5 * fine;
        // The foot is rough and black.
        let foot = 0.16 * clamp(1.4 - high, 0.0, 1.4);
        let scar = smoothstep(0.84, 0.96, scars + foot);
        let grey = 0.10 + 0.25 * clamp(1.2 - high, 0.0, 1.2) + 0.45 * patchy + 0.25 * fine + 0.25 * lines;
        return Bark(0.7 - 0.5 * scar + 0.2 * fine, clamp(max(max(0.6 * lenticel, scar), grey), 0.0, 1.0));
    }
    if surface.pattern == 1u {
        // Smooth: faint wrinkles around, lichen in patches.
        let wrinkle = fractal_noise2(p * vec2(1.2, 9.0), pixel * 6.0, 5u);
        return Bark(0.5 + 0.35 * wrinkle + 0.2 * fine, clamp(0.45 + 1.1 * patchy + 0.5 * wrinkle + 0.5 * fine, 0.0, 1.0));
    }
    // Ridges: long plates that grooves part; square ones on plated bark.
    if coarse <= 0.0 {
        return Bark(0.62, clamp(0.35 + 0.6 * patchy, 0.0, 1.0));
    }
    let stretch = select(vec2(1.5, 0.36), vec2(1.5, 0.5), surface.pattern == 3u);
    let warp = vec2(fractal_noise2(p * 1.3, pixel * 1.3, 6u), fractal_noise2(p * 1.3 + 7.0, pixel * 1.3, 7u));
    let near = cells(p * stretch + warp * 0.5, 10u);
    let plate = smoothstep(0.02, 0.42, near.y - near.x);
    let height = mix(0.62, plate, coarse) + 0.45 * fine;
    let contrast = select(0.75, 0.5, surface.pattern == 3u);
    return Bark(mix(0.7, height, contrast), clamp(0.4 + contrast * (0.45 - 0.8 * height) + 0.6 * patchy, 0.0, 1.0));
}

// Bark without what is smaller than a pixel of a far tree or a twig: the means of `bark`.
fn plain_bark(surface: Surface, uv: vec2<f32>, metres: f32, high: f32) -> Bark {
    let patchy = fractal_noise2(uv / surface.scale * 0.35, metres / surface.scale * 0.35, 9u);
    if surface.pattern == 4u {
        return Bark(0.7, clamp(0.10 + 0.25 * clamp(1.2 - high, 0.0, 1.2) + 0.45 * patchy, 0.0, 1.0));
    }
    let mean = select(select(0.35, 0.37, surface.pattern == 3u), 0.45, surface.pattern == 1u);
    return Bark(0.62, clamp(mean + select(0.6, 1.1, surface.pattern == 1u) * patchy, 0.0, 1.0));
}

// Slope of the bark's finer relief, which is the same on all kinds: ridges along, chinks across.
fn rough_slope(p: vec2<f32>) -> vec2<f32> {
    let step = 0.06;
    var heights = vec3(0.0);
    for (var i = 0u; i < 3u; i++) {
        let q = p + step * vec2(select(0.0, 1.0, i == 1u), select(0.0, 1.0, i == 2u));
        heights[i] = value_noise2(q * vec2(4.3, 1.1), 14u) + 0.45 * value_noise2(q * vec2(11.0, 4.0), 15u);
    }
    return (heights.yz - heights.x) / step;
}

@fragment
fn fragment(in: Varyings, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let surface = surfaces[in.material];
    var albedo = surface.base_color;
    // Sampled outside of branches: derivatives need every pixel of a quad.
    let texel = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0));
    // What branches hide from the pixels about an edge has no derivatives: those of the coordinates,
    // and steps along them, stand for the relief's.
    let uv_x = dpdx(in.uv);
    let uv_y = dpdy(in.uv);
    let metres = sqrt(max(length(uv_x) * length(uv_y), 1e-10));
    let world_x = dpdx(in.world);
    let world_y = dpdy(in.world);
    if surface.layer >= 0 {
        albedo *= texel.rgb;
    }
    let plane = normalize(select(-in.normal, in.normal, front));
    var normal = plane;
    var open = 1.0;
    if plain {
        if surface.pattern != 0u {
            let patches = plain_bark(surface, in.uv, metres, in.high);
            albedo *= mix(surface.ridge, surface.groove, patches.dark);
            albedo = mix(albedo, vec3(0.090, 0.098, 0.042), 0.15 * smoothstep(9.0, 1.0, in.high));
            albedo = mix(albedo, vec3(0.300, 0.310, 0.260), 0.05);
            let moss = smoothstep(0.1, 0.5, 0.55 - 0.45 * in.high) * (1.0 - 0.5 * patches.dark);
            albedo = mix(albedo, vec3(0.050, 0.062, 0.020), 0.65 * moss);
        }
    } else if surface.pattern != 0u {
        let surface_bark = bark(surface, in.uv, metres, in.high);
        albedo *= mix(surface.ridge, surface.groove, surface_bark.dark);
        if has(BARK_RELIEF) && metres < 0.6 * surface.scale {
            let slope_uv = rough_slope(in.uv / surface.scale) * surface_bark.height / surface.scale;
            let rise = vec2(dot(slope_uv, uv_x), dot(slope_uv, uv_y));
            // The height as a bump (Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010).
            let r1 = cross(world_y, normal);
            let r2 = cross(normal, world_x);
            let area = dot(world_x, r1);
            let depth = surface.scale * 0.09;
            let slope = sign(area) * (rise.x * r1 + rise.y * r2) * depth;
            normal = normalize(abs(area) * normal - slope + plane * 1e-9);
            open = clamp(0.45 + 0.75 * surface_bark.height, 0.3, 1.0);
        }
        // Algae grow in streaks where rain runs down, lichen in pale crusts.
        let streaks = fractal_noise2(in.uv * vec2(2.6, 0.35), metres * 2.6, 16u) + 0.35 * fractal_noise2(in.uv * 1.1, metres, 18u);
        albedo = mix(albedo, vec3(0.090, 0.098, 0.042), 0.6 * smoothstep(0.0, 0.3, streaks) * smoothstep(9.0, 1.0, in.high));
        let crusts = fractal_noise2(in.uv * 6.5, metres * 6.5, 17u);
        albedo = mix(albedo, vec3(0.260, 0.270, 0.220), 0.35 * smoothstep(0.12, 0.2, crusts));
        // Moss and soil climb the foot.
        let moss = smoothstep(0.1, 0.5, fractal_noise2(in.uv * 3.0, 0.0, 12u) + 0.55 - 0.45 * in.high) * (1.0 - 0.5 * surface_bark.dark);
        albedo = mix(albedo, vec3(0.050, 0.062, 0.020), 0.65 * moss);
        let soil = 1.0 - smoothstep(0.0, 0.28, in.high + 0.1 * fractal_noise2(in.uv * 9.0, 0.0, 13u));
        albedo = mix(albedo, vec3(0.060, 0.043, 0.028), 0.8 * soil);
        open *= mix(1.0, 0.55, soil);
    }
    if explains() {
        return vec4(explained(normal, normalize(frame.eye - in.world), vec3(0.30, 0.13, 0.05)), 1.0);
    }
    let sun_way = frame.sun_direction;
    let sun = max(dot(normal, sun_way), 0.0) * step(0.0, dot(plane, sun_way));
    let taps = min(frame.shadow_taps, select(6u, 2u, plain));
    let reach = sun_visibility(in.world, plane, in.clip.xy, taps, 1.5);
    // Light among leaves has their colour.
    let leaves = frame.litter / max(dot(frame.litter, vec3(1.0 / 3.0)), 1e-3);
    let among = mix(vec3(1.0), leaves, select(0.0, 0.28, model.leaf_count > 0u));
    // A side that looks away from the sun sees what the sun shines on.
    let away = 0.5 - 0.5 * dot(normal, normalize(vec3(sun_way.x, 0.0, sun_way.z) + vec3(1e-4)));
    let bounced = frame.sun_color * frame.litter * (0.07 * away * away * sun_way.y);
    let around = ambient(normal) * among * 0.85 + select(vec3(0.0), bounced, model.leaf_count > 0u);
    let light = frame.sun_color * (sun / PI * reach * mix(open, 1.0, 0.5)) + around * (in.shade * open);
    return vec4(through_air(albedo * light, in.world), 1.0);
}
