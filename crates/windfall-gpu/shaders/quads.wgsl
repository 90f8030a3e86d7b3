// Small leaves, placed and lit by compute: what is left to do is to draw their corners.

struct Corner {
    // Clip space x, y and w, which is not above 0 where there is nothing to draw; radiance.
    @location(0) packed: vec4<u32>,
}

struct Lit {
    @builtin(position) clip: vec4<f32>,
    // All corners of a leaf have the same.
    @location(0) @interpolate(flat) radiance: vec3<f32>,
}

@vertex
fn vertex(in: Corner) -> Lit {
    let at = bitcast<vec3<f32>>(in.packed.xyz);
    // Infinitely far is 0: every point's z in clip space is the near plane's distance.
    return Lit(vec4(at.xy, frame.clip_from_world[3].z, at.z), unpack_radiance(in.packed.w));
}

@fragment
fn fragment(in: Lit) -> @location(0) vec4<f32> {
    return vec4(in.radiance, 1.0);
}
