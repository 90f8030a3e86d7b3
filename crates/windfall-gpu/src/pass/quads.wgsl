// Small leaves, placed and lit by compute: what is left to do is to draw their corners.

struct Corner {
    // See quad_corner. All corners of a leaf that is not there are the same: it has no area.
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
    let depth = frame.depth_from_w.x * at.z + frame.depth_from_w.y;
    let clip = select(vec4(at.xy, depth, at.z), vec4(at, 1.0), frame.orthographic == 1u);
    return Lit(clip, unpack_radiance(in.packed.w));
}

@fragment
fn fragment(in: Lit) -> @location(0) vec4<f32> {
    return vec4(in.radiance, 1.0);
}
