// Eliminated leaves (VB 5): static geometry that withers, and shrinks before another leaf takes its slot.

struct LitterVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) place_scale: vec4<f32>,
    @location(4) orientation: vec4<f32>,
    @location(5) color_ambient: vec4<f32>,
    @location(6) look: u32,
    // When it landed and when it has vanished, on the clock of FallFrame.time.
    @location(7) times: vec2<f32>,
}

@vertex
fn lying(in: LitterVertex) -> Varyings {
    return lying_vertex(in);
}

fn lying_vertex(in: LitterVertex) -> Varyings {
    let q = normalize(in.orientation);
    let scale = in.place_scale.w * vanishing(in.times.y);
    let world = in.place_scale.xyz + turn_by(q, in.position.xyz) * scale;
    // Encoded as in LooseLeaf: the root of half the colour.
    var color = in.color_ambient.rgb * sqrt(withering(since(in.times.x)));
    // Strategy "cpu" draws leaves in the air too.
    if fall.color_loops == 1u && since(in.times.x) >= 0.0 {
        color = sqrt(0.5 * LANDED_COLOR);
    }
    let normal = turn_by(q, in.normal.xyz);
    return loose_varyings(world, in.place_scale.xyz, normal, in.uv, vec4(color, in.color_ambient.w), in.look);
}
