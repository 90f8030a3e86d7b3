// Grass about the camera: the blades that find_grass.wgsl has found.

@group(2) @binding(0) var<storage, read> tufts: array<Tuft>;
@group(2) @binding(1) var<storage, read> blades: array<u32>;

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    // Of a blade that is thinner than a sample nothing can be interpolated: all but the last is its
    // own.
    @location(0) @interpolate(flat) root: vec3<f32>,
    @location(1) @interpolate(flat) color: vec3<f32>,
    @location(2) @interpolate(flat) normal: vec3<f32>,
    // Along the blade, 0 at the root.
    @location(3) along: f32,
}

// Three vertices a blade: two at the root, one at the tip.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varyings {
    var out: Varyings;
    let corner = index % 3u;
    let found = blades[index / 3u];
    let tuft = tufts[found / BLADES];
    let wide = CELL * select(1.0, 3.0, tuft.ring == 1u);
    let own = hash(tuft.key, 16u + found % BLADES);
    let at = tuft.at;
    let away = distance(at, frame.eye.xz);
    let angle = unit(own) * 2.0 * PI;
    let out_way = vec2(cos(angle), sin(angle));
    let across = vec2(-out_way.y, out_way.x);
    let tall = (0.05 + 0.15 * unit(hash(own, 1u)) * unit(hash(tuft.key, 3u)) + 0.03 * f32(tuft.ring)) * (0.6 + 0.5 * tuft.lush) * (0.35 + 0.65 * tuft.rim);
    let bend = tall * (0.25 + 0.7 * unit(hash(own, 2u)));
    let foot = at + out_way * (0.3 * wide) * unit(hash(own, 3u));
    let root = vec3(foot.x, terrain_height(foot) - 0.004, foot.y);
    let thin = blade_width(own, away);
    let thick = max(thin, 0.8 * pixel_at(away));
    var p = root;
    var along = 0.0;
    if corner == 2u {
        p += vec3(out_way.x * bend, tall, out_way.y * bend);
        if frame.sway > 0.0 {
            let wind = wind_at(p);
            let beat = 0.6 + 0.4 * swing(p, vec3(0.6, 0.0, 0.5), 1.40625);
            let push = wind * min(0.02 * beat, 0.5 / max(length(wind), 1e-3)) * tall * 5.0;
            p += vec3(push.x, 0.0, push.y);
        }
        along = 1.0;
    } else {
        let sideways = across * select(-thick, thick, corner == 1u);
        p += vec3(sideways.x, 0.0, sideways.y);
    }
    let straw = smoothstep(0.45, 1.0, unit(hash(own, 5u)) * 0.6 + 0.55 * tuft.dry);
    // Few stand for many: with less contrast, as leaves (SFS, equation 4).
    let contrast = sqrt(thin / thick);
    out.color = mix(mix(vec3(0.056, 0.078, 0.018), vec3(0.100, 0.112, 0.030), tuft.dry), vec3(0.240, 0.185, 0.085), mix(0.25 * tuft.dry, straw, contrast))
        * (1.0 + (0.6 * unit(hash(own, 6u)) - 0.3) * contrast);
    out.root = root;
    out.along = along;
    out.normal = normalize(vec3(out_way.x * 0.6, 1.0, out_way.y * 0.6));
    out.clip = frame.clip_from_world * vec4(p, 1.0);
    return out;
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let normal = in.normal;
    let along = select(0.5, in.along, in.along >= 0.0 && in.along <= 1.0); // not a number neither
    let sun = frame.sun_direction;
    let view = normalize(frame.eye - in.root);
    let reach = sun_visibility(in.root + vec3(0.0, 0.06, 0.0), vec3(0.0), in.clip.xy, min(frame.shadow_taps, 4u), 1.5);
    // Blades pass light as leaves do: brighter against the sun.
    let through = pow(max(-dot(view, sun), 0.0), 3.0);
    let lit = 0.55 * max(dot(normal, sun), 0.0) + 0.25 + 0.9 * through;
    let deep = mix(0.28, 1.0, along);
    let light = frame.sun_color * (reach * lit * mix(0.5, 1.0, along) / PI) + ambient(normal) * deep;
    return vec4(through_air(in.color * light, in.root), 1.0);
}
