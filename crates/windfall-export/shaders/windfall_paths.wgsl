// Leaves from a path texture and six texels of each leaf, in Windfall's axes and metres. Textures are read by the
// caller; paths with linear filtering along a row. `windfall_paths.hlsl` is generated from this.
//
// A shader: read the leaf's texels; `windfall_path_times` says at which times its path is to be read, as seconds on the
// path; with the displacement at the first and the orientation at the second, `windfall_path_place` and
// `windfall_path_rotation` give the leaf's pose.

// Times on the path for place (x) and orientation (y), seconds, and how far the leaf has settled (z, 0 to 1).
// `elapsed` is the time since the detachment; `fall` texel 1, `variant` texel 4; `soft` and `settle` the sidecar's.
fn windfall_path_times(elapsed: f32, fall: vec4<f32>, variant: vec4<f32>, soft: f32, settle: f32) -> vec3<f32> {
    let now = clamp(elapsed, 0.0, fall.w);
    let settles = clamp(settle, 0.0, fall.w);
    let done = clamp(1.0 - (fall.w - now) / max(settles, 1e-6), 0.0, 1.0);
    let turning = select(now, fall.w - settles + settles * (done - 0.5 * done * done), done > 0.0);
    let t = vec2<f32>(now, turning);
    let early = t * t / max(2.0 * soft, 1e-6);
    let late = t - vec2<f32>(0.5 * max(soft, 0.0));
    return vec3<f32>(select(late, early, t < vec2<f32>(soft)) * variant.w, done);
}

fn windfall_smooth(x: f32) -> f32 {
    let s = clamp(x, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

fn windfall_multiply(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

// From no rotation to `q`, by the shorter way.
fn windfall_part(q: vec4<f32>, share: f32) -> vec4<f32> {
    let nearer = select(q, -q, q.w < 0.0);
    let angle = acos(min(nearer.w, 1.0));
    let along = nearer.xyz / max(sqrt(max(1.0 - nearer.w * nearer.w, 0.0)), 1e-6);
    return vec4<f32>(along * sin(angle * share), cos(angle * share));
}

// Way of the wind so far as a share of that at the landing: of a steady wind that the leaf takes on within `response`.
fn windfall_drift(elapsed: f32, fall_time: f32, response: f32) -> f32 {
    let lag = max(response, 1e-4);
    let whole = fall_time - lag * (1.0 - exp(-fall_time / lag));
    return (elapsed - lag * (1.0 - exp(-elapsed / lag))) / max(whole, 1e-6);
}

// Centre of a leaf. `twig`, `fall`, `variant` and `wind` are texels 0, 1, 4 and 5; `along` the displacement of the path.
fn windfall_path_place(
    elapsed: f32,
    twig: vec4<f32>,
    fall: vec4<f32>,
    variant: vec4<f32>,
    wind: vec4<f32>,
    along: vec3<f32>,
    done: f32,
    response: f32,
) -> vec3<f32> {
    let now = clamp(elapsed, 0.0, fall.w);
    let s = sin(variant.x);
    let c = cos(variant.x);
    let scaled = vec2<f32>(along.x * variant.y, along.z * variant.z);
    let turned = vec3<f32>(c * scaled.x + s * scaled.y, along.y, c * scaled.y - s * scaled.x);
    let blown = vec3<f32>(wind.x, 0.0, wind.y) * windfall_drift(now, fall.w, response);
    return twig.xyz + turned + blown + vec3<f32>(0.0, wind.w * windfall_smooth(done), 0.0);
}

// Rotation of a leaf. `from_twig`, `settle` and `variant` are texels 2, 3 and 4; `on_path` the orientation of the path,
// `drop` how far it has come down (alpha of the displacement).
fn windfall_path_rotation(
    from_twig: vec4<f32>,
    settle: vec4<f32>,
    variant: vec4<f32>,
    on_path: vec4<f32>,
    drop: f32,
    soft_drop: f32,
    done: f32,
) -> vec4<f32> {
    let yaw = vec4<f32>(0.0, sin(0.5 * variant.x), 0.0, cos(0.5 * variant.x));
    let eased = select(1.0, windfall_smooth(drop / max(soft_drop, 1e-6)), soft_drop > 0.0);
    let flying = windfall_multiply(windfall_multiply(yaw, on_path), windfall_part(from_twig, 1.0 - eased));
    return windfall_multiply(flying, windfall_part(settle, windfall_smooth(done)));
}
