// Leaves from vertex animation textures: what a vertex shader does with the texels. Textures are read by the caller,
// without filtering, mip levels or sRGB. `windfall_vat.hlsl` is generated from this.

// The texel as stored (0 to 1 if it has 16 bits), to what it means: `low` and `high` are the sidecar's.
fn windfall_decode(texel: vec4<f32>, low: vec4<f32>, high: vec4<f32>) -> vec4<f32> {
    return low + texel * (high - low);
}

// Two frames, from 0, and how far the moment is from the first to the second.
fn windfall_frames(seconds: f32, fps: f32, frames: f32) -> vec3<f32> {
    let at = clamp(seconds * fps, 0.0, frames - 1.0);
    let first = floor(at);
    return vec3<f32>(first, min(first + 1.0, frames - 1.0), at - first);
}

// Place of a leaf's texel in the texture. `address` is TEXCOORD_1, its texel in frame 0; `height` the texture's, texels.
fn windfall_texel(address: vec2<f32>, at_frame: f32, height: f32) -> vec2<f32> {
    return vec2<f32>(address.x, address.y + at_frame / height);
}

fn windfall_rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

// The rotation between two, by the shorter way.
fn windfall_between(a: vec4<f32>, b: vec4<f32>, share: f32) -> vec4<f32> {
    let nearer = select(b, -b, dot(a, b) < 0.0);
    return normalize(mix(a, nearer, share));
}

// A vertex in the engine's axes and units. `local` is the vertex about its leaf's centre; the places' w is 0 where the
// leaf is hidden, of which it takes that of the first frame.
fn windfall_vertex(
    local: vec3<f32>,
    place_a: vec4<f32>,
    place_b: vec4<f32>,
    rotation: vec4<f32>,
    share: f32,
) -> vec3<f32> {
    return mix(place_a.xyz, place_b.xyz, share) + windfall_rotate(rotation, local) * place_a.w;
}
