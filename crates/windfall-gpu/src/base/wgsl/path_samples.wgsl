// Samples of paths in the tables. A pass may have them elsewhere.

fn path_sample(i: u32) -> PathSample {
    let t = table(i);
    // Whole numbers: 21 bits of x and z, 22 of y.
    let place = bitcast<vec3<i32>>(vec3(t.x, (t.x << 21u) | ((t.y & 0x7ffu) << 10u), t.y));
    return PathSample(
        vec3<f32>(place >> vec3(11u, 10u, 11u)) * fall.path_grain,
        vec4(unpack2x16snorm(t.z), unpack2x16snorm(t.w)),
    );
}
