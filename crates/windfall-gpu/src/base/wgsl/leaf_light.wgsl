// What a leaf does to light: the twin of windfall_core::light::leaf, where the sources are named.

const WAX: f32 = 0.034;
const WAX_ALPHA: f32 = 0.25;

struct LeafDiffuse {
    reflected: vec3<f32>,
    passed: vec3<f32>,
}

fn leaf_diffuse(color: vec3<f32>) -> LeafDiffuse {
    let tint = color / max(max(color.r, max(color.g, color.b)), 1e-3);
    let through = color * tint * 0.8;
    let all = color + through;
    let keep = 0.95 / max(max(all.r, max(all.g, all.b)), 0.95);
    return LeafDiffuse(color * keep, through * keep);
}

fn wax_fresnel(cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    return WAX + (1.0 - WAX) * x * x * x * x * x;
}

// Diffuse radiance towards the viewer per irradiance on a surface that faces the light: `front` and
// `back` are the cosines of the light on the viewer's side and on the other, one of them 0 for one leaf,
// `volume` that of the bent normal, `n_v` that of the view.
fn leaf_body(leaf: LeafDiffuse, front: f32, back: f32, volume: f32, bend: f32, n_v: f32) -> vec3<f32> {
    let bent = front * (1.0 - bend) + max(volume, 0.0) * bend;
    return (leaf.reflected * bent + leaf.passed * back) * ((1.0 - wax_fresnel(n_v)) / PI);
}

// The wax's gloss; `normal` is on the viewer's side, `facing` its cosine with the light.
fn leaf_gloss(normal: vec3<f32>, facing: f32, light: vec3<f32>, view: vec3<f32>) -> f32 {
    if facing <= 0.0 {
        return 0.0;
    }
    let n_v = max(dot(normal, view), 1e-3);
    let half_way = normalize(light + view);
    let n_h = clamp(dot(normal, half_way), 0.0, 1.0);
    let a2 = WAX_ALPHA * WAX_ALPHA;
    let d = n_h * n_h * (a2 - 1.0) + 1.0;
    let visibility = 0.5 / (2.0 * facing * n_v * (1.0 - WAX_ALPHA) + (facing + n_v) * WAX_ALPHA);
    return a2 / (PI * d * d) * visibility * wax_fresnel(max(dot(view, half_way), 0.0)) * facing;
}

// The gloss of leaves that lean in every direction alike, in the mean over those that are seen.
fn mean_gloss(light: vec3<f32>, view: vec3<f32>) -> f32 {
    let cosine = max(dot(view, normalize(light + view + vec3(0.0, 1e-4, 0.0))), 0.0);
    return wax_fresnel(cosine) / (4.0 * PI) * 2.16 * cosine / (1.0 + cosine);
}

// What leaves at a place of the crown have of the ambient light in the mean: the twin of
// windfall_core::simplify::Shading::ambient_at.
fn ambient_at(ambient: vec3<f32>, from_center: vec3<f32>) -> f32 {
    return clamp(dot(ambient, vec3(1.0, length(from_center), from_center.y)), 0.0, 1.0);
}
