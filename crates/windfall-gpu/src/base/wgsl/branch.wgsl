// How far a vertex of the wood moves along its normal, metres, by its branch's radius and the error about
// which that vanishes: the twin of windfall_core::simplify::Branch::widening.
fn widening(branch: vec2<f32>, error: f32) -> f32 {
    let left = clamp((1.2 - error / branch.y) / 0.4, 0.0, 1.0);
    return max(branch.x, error) * left - branch.x;
}
