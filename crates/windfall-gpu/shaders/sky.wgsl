// The sky behind everything.

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
    return out;
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let direction = normalize(in.far.xyz / in.far.w - frame.eye);
    let cosine = dot(direction, frame.sun_direction);
    let disc = smoothstep(0.99985, 0.99992, cosine) * 40.0;
    return vec4(sky_radiance(direction) + frame.sun_color * disc * 0.5, 1.0);
}
