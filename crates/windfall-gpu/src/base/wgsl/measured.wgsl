// A factor that windfall_core::simplify::Visibility has measured, where the share `lambda` of the leaves is drawn:
// straight over its logarithm.
fn measured_factor(measured: vec3<f32>, lambda: f32) -> f32 {
    let steps = clamp(vec3(-0.5 * log2(max(lambda, 1e-6))) - vec3(0.0, 1.0, 2.0), vec3(0.0), vec3(1.0));
    return 1.0 + dot(steps, measured - vec3(1.0, measured.xy));
}

// Whether something with a chance number between 0 and 1 belongs to the share that is chosen: 1 or 0, and between
// for a few, so that nothing flashes up when the share changes. In the mean it is the share.
fn chosen(share: f32, chance: f32) -> f32 {
    let fade = clamp(min(share, 1.0 - share), 1e-4, 0.0625);
    return clamp(0.5 + 0.5 * (share - chance) / fade, 0.0, 1.0);
}
