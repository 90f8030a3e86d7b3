// Corners of quads, 16 bytes each: place in clip space: x, y, and w (z of an orthographic view), and radiance with a shared exponent (OpenGL's
// EXT_texture_shared_exponent, RGB9E5).

fn pack_radiance(radiance: vec3<f32>) -> u32 {
    let c = clamp(radiance, vec3(0.0), vec3(65408.0));
    let largest = max(c.r, max(c.g, c.b));
    // The power of two above the largest; 511.5 rounds to 512, which takes the next.
    let exponent = max(i32(bitcast<u32>(largest * (512.0 / 511.5)) >> 23u) - 126, -15);
    let scale = bitcast<f32>(u32(127 + 9 - exponent) << 23u);
    let m = vec3<u32>(c * scale + 0.5);
    return m.r | (m.g << 9u) | (m.b << 18u) | (u32(exponent + 15) << 27u);
}

fn unpack_radiance(packed: u32) -> vec3<f32> {
    let scale = bitcast<f32>(((packed >> 27u) + 103u) << 23u);
    return vec3(f32(packed & 511u), f32((packed >> 9u) & 511u), f32((packed >> 18u) & 511u)) * scale;
}

fn quad_corner(clip: vec4<f32>, radiance: u32) -> vec4<u32> {
    // In perspective z follows from w, else w is 1.
    let at = vec3(clip.xy, select(clip.w, clip.z, frame.orthographic == 1u));
    return vec4(bitcast<vec3<u32>>(at), radiance);
}
