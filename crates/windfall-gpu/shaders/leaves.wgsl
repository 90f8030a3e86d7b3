// Leaves on their twigs.

@group(1) @binding(0) var<uniform> model: Model;
@group(1) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(1) @binding(2) var pictures: texture_2d_array<f32>;
@group(1) @binding(3) var picture_sampler: sampler;

struct LeafVertex {
    @location(0) center: vec3<f32>,
    @location(1) leaf: u32,
    @location(2) offset_ambient: vec4<f32>,
    @location(3) normal: vec4<f32>,
    @location(4) bent_normal: vec4<f32>,
    @location(5) uv: vec2<f32>,
    @location(6) material_shed: u32,
}

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) bent_normal: vec3<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) @interpolate(flat) color: vec3<f32>,
    @location(5) @interpolate(flat) material: u32,
    @location(6) @interpolate(flat) ambient: f32,
}

// Behind the camera: nothing of it is drawn.
const NOWHERE = vec4<f32>(0.0, 0.0, -1.0, 1.0);

@vertex
fn vertex(in: LeafVertex, tree: Tree) -> Varyings {
    var out: Varyings;
    out.clip = NOWHERE;
    if (in.material_shed & 0xffffffu) < tree.seed_detached.y {
        return out; // in the air or on the ground
    }
    out.world = world_from_tree(tree, in.center + in.offset_ambient.xyz);
    out.clip = frame.clip_from_world * vec4(out.world, 1.0);
    out.normal = turn(tree, in.normal.xyz);
    out.bent_normal = turn(tree, in.bent_normal.xyz);
    out.uv = in.uv;
    let high = (in.center.y - model.crown_center.y) / model.crown_extent.y;
    let season = leaf_season(tree.seed_detached.x, tree.turn_season.z, in.leaf, high, model.palette_spread);
    out.color = vec3(season.brightness);
    if model.palette_count > 0u {
        let x = season.phase * f32(model.palette_count - 1u);
        let i = min(u32(x), model.palette_count - 2u);
        out.color *= mix(model.palette[i].rgb, model.palette[i + 1u].rgb, x - f32(i));
    }
    out.material = in.material_shed >> 24u;
    let inside = length((in.center - model.crown_center) / model.crown_extent);
    out.ambient = in.offset_ambient.w * crown_ambient(inside);
    return out;
}

// A leaf in the air or on the ground: the shape's vertices, and one LooseLeaf per instance.
struct LooseVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) place_scale: vec4<f32>,
    @location(4) orientation: vec4<f32>,
    @location(5) color_ambient: vec4<f32>,
    @location(6) look: u32,
}

fn turn_by(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

// What a vertex in the air or on the ground has of its leaf: the LooseLeaf's colour and look.
fn loose_varyings(world: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, color: vec4<f32>, look: u32) -> Varyings {
    var out: Varyings;
    out.world = world;
    out.clip = frame.clip_from_world * vec4(world, 1.0);
    out.normal = normal;
    // The crown's bent normal on the twig; in the air light comes from above.
    out.bent_normal = mix(from_octahedral(unpack4x8snorm(look).yz), vec3(0.0, 1.0, 0.0), unpack4x8unorm(look).w);
    out.uv = uv;
    out.color = color.rgb * color.rgb * 2.0;
    out.material = look & 0xffu;
    out.ambient = color.w;
    return out;
}

fn posed(position: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, leaf: LooseLeaf) -> Varyings {
    let q = normalize(vec4(unpack2x16snorm(leaf.orientation_xy), unpack2x16snorm(leaf.orientation_zw)));
    let world = leaf.position + turn_by(q, position) * leaf.scale;
    return loose_varyings(world, turn_by(q, normal), uv, unpack4x8unorm(leaf.color), leaf.look);
}

@vertex
fn loose(in: LooseVertex) -> Varyings {
    let q = normalize(in.orientation);
    let world = in.place_scale.xyz + turn_by(q, in.position.xyz) * in.place_scale.w;
    return loose_varyings(world, turn_by(q, in.normal.xyz), in.uv, in.color_ambient, in.look);
}

// Radiance of a leaf towards the eye: both sides reflect, and light from behind shines through.
fn leaf_radiance(in: Varyings, albedo: vec3<f32>) -> vec3<f32> {
    let view = normalize(frame.eye - in.world);
    var normal = normalize(in.normal);
    normal = select(-normal, normal, dot(normal, view) >= 0.0);
    // Opposite normals may cancel: a nudge keeps the sum from being nothing.
    let bent = normalize(in.bent_normal + vec3(0.0, 1e-3, 0.0));
    let sun = frame.sun_direction;
    // Leaves are thin and many: what shadow maps miss between them, depth in the crown stands for.
    let reach = sun_visibility(in.world, 2.5) * mix(0.7, 1.0, in.ambient);
    let facing = dot(normal, sun);
    let volume = max(dot(bent, sun), 0.0);
    let reflected = mix(max(facing, 0.0), volume, 0.35);
    // Transmitted light is more saturated: it passed the pigments once more.
    let through = max(-facing, 0.0) * 0.55 * albedo * (0.6 + 0.8 * albedo / (max(albedo.r, max(albedo.g, albedo.b)) + 1e-3));
    let half_way = normalize(view + sun);
    let gloss = 0.04 * pow(max(dot(normal, half_way), 0.0), 24.0) * step(0.0, facing);
    let direct = frame.sun_color * reach * (albedo * reflected / PI + through / PI + gloss);
    let indirect = albedo * ambient(normalize(mix(normal, bent, 0.45))) * in.ambient;
    return direct + indirect;
}

@fragment
fn solid(in: Varyings) -> @location(0) vec4<f32> {
    let surface = surfaces[in.material];
    var albedo = tinted(in.color, surface);
    if surface.layer >= 0 {
        albedo = textured(in, surface).rgb;
    } else {
        // Built-in leaves: a pale midrib, and a margin that dries first.
        let across = abs(in.uv.x - 0.5);
        let rib = 1.0 - smoothstep(0.008, 0.03, across);
        albedo *= 1.0 + 0.25 * rib - 0.18 * smoothstep(0.25, 0.5, across);
    }
    return vec4(through_air(leaf_radiance(in, albedo), in.world), 1.0);
}

fn tinted(color: vec3<f32>, surface: Surface) -> vec3<f32> {
    return select(color, color * surface.base_color, model.palette_count == 0u);
}

fn textured(in: Varyings, surface: Surface) -> vec4<f32> {
    let texel = textureSample(pictures, picture_sampler, in.uv, surface.layer);
    if model.palette_count == 0u {
        return vec4(tinted(in.color, surface) * texel.rgb, texel.a);
    }
    // Keep the picture's light and dark, take the season's colour.
    let light = dot(texel.rgb, vec3(0.2126, 0.7152, 0.0722)) / model.texture_luminance;
    return vec4(in.color * clamp(light, 0.0, 2.0), texel.a);
}

@fragment
fn masked_shadow(in: Varyings) {
    let surface = surfaces[in.material];
    let alpha = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0)).a;
    if surface.masked == 1u && surface.layer >= 0 && alpha < 0.5 {
        discard;
    }
}

@fragment
fn masked(in: Varyings) -> @location(0) vec4<f32> {
    let surface = surfaces[in.material];
    var texel = vec4(tinted(in.color, surface), 1.0);
    if surface.layer >= 0 {
        texel = textured(in, surface);
    }
    // The hole's edge one pixel wide, so that coverage gives it as many steps as there are samples.
    let width = max(fwidth(texel.a), 1e-3);
    let alpha = select(1.0, clamp((texel.a - 0.5) / width + 0.5, 0.0, 1.0), surface.masked == 1u);
    if alpha <= 0.0 {
        discard;
    }
    return vec4(through_air(leaf_radiance(in, texel.rgb), in.world), alpha);
}
