// A factor that windfall_core::simplify::Visibility has measured, where the share `lambda` of the leaves is drawn:
// straight over its logarithm.
fn measured_factor(measured: vec3<f32>, lambda: f32) -> f32 {
    let steps = clamp(vec3(-0.5 * log2(max(lambda, 1e-6))) - vec3(0.0, 1.0, 2.0), vec3(0.0), vec3(1.0));
    return 1.0 + dot(steps, measured - vec3(1.0, measured.xy));
}
