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
}

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) shade: f32,
    @location(4) @interpolate(flat) material: u32,
}

@vertex
fn vertex(in: WoodVertex, tree: Tree) -> Varyings {
    var out: Varyings;
    out.world = world_from_tree(tree, in.position);
    out.clip = frame.clip_from_world * vec4(out.world, 1.0);
    out.normal = turn(tree, in.normal.xyz);
    out.uv = in.uv;
    // Inside the crown leaves take the light.
    let inside = length((in.position - model.crown_center) / model.crown_extent);
    out.shade = select(1.0, mix(0.4, 1.0, smoothstep(0.3, 1.1, inside)), model.leaf_count > 0u);
    out.material = in.material;
    return out;
}

// Bark: 0 ridge to 1 groove. x turns once around per whole number, y is metres along.
fn groove(surface: Surface, uv: vec2<f32>) -> f32 {
    let along = uv.y / surface.scale;
    let around = abs(fract(uv.x) * 2.0 - 1.0); // meets itself on the other side
    let width = max(fwidth(along), 2e-3);
    if surface.pattern == 4u {
        // Paper: dark lenticels, wide and thin, and now and then a scar.
        let lenticel = value_noise2(vec2(around * 5.0, along * 9.0), 3u);
        let scar = value_noise2(vec2(around * 2.0, along * 1.3), 4u);
        let lines = smoothstep(0.70, 0.80, lenticel) * (1.0 - smoothstep(0.2, 0.8, width * 9.0));
        return max(lines, smoothstep(0.78, 0.88, scar));
    }
    if surface.pattern == 1u {
        return 0.5 + fractal_noise2(vec2(around * 3.0, along), width, 5u);
    }
    let stretch = select(vec2(18.0, 1.0), vec2(9.0, 2.2), surface.pattern == 3u);
    let warp = value_noise2(vec2(around * 4.0, along * 1.5), 7u);
    let ridges = value_noise2(vec2(around * stretch.x + warp * 2.0, along * stretch.y), 6u);
    let fine = fractal_noise2(vec2(around * 30.0, along * 8.0), width * 8.0, 8u);
    return smoothstep(0.25, 0.75, ridges + 0.5 * fine);
}

@fragment
fn fragment(in: Varyings, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let surface = surfaces[in.material];
    var albedo = surface.base_color;
    // Sampled outside of branches: derivatives need every pixel of a quad.
    let texel = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0));
    if surface.layer >= 0 {
        albedo *= texel.rgb;
    }
    if surface.pattern != 0u {
        albedo *= mix(surface.ridge, surface.groove, clamp(groove(surface, in.uv), 0.0, 1.0));
    }
    let normal = normalize(select(-in.normal, in.normal, front));
    let sun = max(dot(normal, frame.sun_direction), 0.0);
    let light = frame.sun_color * sun / PI * sun_visibility(in.world + normal * 0.03, 2.0) + ambient(normal) * in.shade;
    return vec4(through_air(albedo * light, in.world), 1.0);
}
