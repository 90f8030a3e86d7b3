// How a tree is drawn at its distance, equations 1 to 6: windfall_core::simplify is the reference.

struct Level {
    lambda: f32,
    radius: f32,
    growth: f32,
    contrast: f32,
}

// 1 - exp(x), precise for small x.
fn one_minus_exp(x: f32) -> f32 {
    return select(1.0 - exp(x), -x * (1.0 + x * (0.5 + x * (1.0 / 6.0))), abs(x) < 0.02);
}

// ln(1 - x), precise for small x.
fn log_one_minus(x: f32) -> f32 {
    return select(log(1.0 - x), -x * (1.0 + x * (0.5 + x * (1.0 / 3.0))), abs(x) < 0.02);
}

fn fade_radius(list: TreeList, lambda: f32) -> f32 {
    var radius = list.range;
    switch list.range_kind {
        case 1u: { radius *= 1.0 - lambda; }
        case 2u: { radius *= (1.0 - lambda) * (1.0 - lambda); }
        case 3u: { radius *= lambda; }
        default: {}
    }
    return select(radius, min(radius, 1.0 - lambda), (list.flags & 1u) != 0u);
}

// Factor on the area of the leaves that are left: equation 3, as the crown needs it.
fn area_scale(crown: Crown, lambda: f32) -> f32 {
    let s = one_minus_exp(crown.log_hidden / lambda) / crown.visible_share;
    return max(s * measured_factor(crown.disocclusion, lambda), 1.0);
}

// Its inverse.
fn share_for(crown: Crown, s: f32) -> f32 {
    var lambda = 1.0;
    for (var round = 0u; round < 24u; round++) {
        let hidden = crown.visible_share * s / measured_factor(crown.disocclusion, lambda);
        if hidden >= 1.0 {
            return 0.0;
        }
        lambda = min(crown.log_hidden / log_one_minus(hidden), 1.0);
    }
    return lambda;
}

// What a pixel's mean leaves of the variance between leaves as large as squares of `side` pixels.
fn variance_left(side: f32) -> f32 {
    let along = select(side * (1.0 - side / 3.0), 1.0 - 1.0 / (3.0 * side), side >= 1.0);
    return along * along;
}

// The same of leaves with holes: how much of them is there, and how large the pieces are.
fn variance_left_of(holes: vec2<f32>, side: f32) -> f32 {
    return mix(variance_left(max(side * holes.y, 1e-3)), variance_left(max(side, 1e-3)), holes.x);
}

// What is left of the contrast between leaves: equation 4, for leaves that may be as large as pixels. `pixel` is
// the size of a pixel at the leaves, metres.
fn contrast(list: TreeList, crown: Crown, lambda: f32, leaf_side: f32, pixel: f32) -> f32 {
    if list.contrast_pixels <= 0.0 {
        return sqrt(lambda);
    }
    let holes = unpack2x16float(crown.holes);
    let side = leaf_side / (pixel * list.contrast_pixels);
    let samples = f32(SAMPLES) * list.contrast_pixels * list.contrast_pixels;
    let left = variance_left_of(holes, side * inverseSqrt(lambda));
    let noise = holes.x * (1.0 - left) * (1.0 - lambda) / samples;
    return sqrt(variance_left_of(holes, side) / (left + noise));
}

// `scale` is the tree's, on the model's lengths.
fn tree_level(list: TreeList, crown: Crown, scale: f32, center: vec3<f32>) -> Level {
    let away = max(distance(center, list.eye), 1e-3);
    let seen = crown.radius * scale * list.pixels / away;
    let b = min(select(list.reduction / (away * away), list.reduction * seen * seen, (list.flags & 4u) != 0u), 1.0);
    // 0^0 and the rounding of pow: a tree in full is exactly that.
    let wanted = select(pow(b, list.exponent), 1.0, b >= 1.0 || list.exponent == 0.0);
    if wanted >= 1.0 {
        return Level(1.0, 0.0, 1.0, 1.0);
    }
    var lambda = wanted;
    var growth = 1.0;
    if list.growth_factor >= 0.0 {
        let size = crown.leaf_length * scale * list.pixels / away;
        let most = max(max(list.growth_factor, list.growth_pixels / max(size, 1e-9)), 1.0);
        if area_scale(crown, wanted) > most * most {
            lambda = clamp(share_for(crown, most * most), wanted, 1.0);
        }
        growth = min(sqrt(area_scale(crown, lambda)), most);
    }
    let left = contrast(list, crown, lambda, crown.leaf_side * scale, away / list.pixels);
    return Level(lambda, fade_radius(list, lambda), growth, left);
}

// Bounds of the lengths of a tree's leaves in the picture, pixels: windfall_core::simplify::Simplification::leaf_range.
fn leaf_range(list: TreeList, crown: Crown, level: Level, scale: f32, center: vec3<f32>) -> vec2<f32> {
    let away = distance(center, list.eye);
    let radius = crown.radius * scale;
    let lengths = unpack2x16float(crown.leaf_lengths) * (scale * level.growth * list.pixels);
    let shortest = select(lengths.x, 0.0, level.lambda < 1.0);
    return vec2(shortest / max(away + radius, 1e-3), lengths.y / max(away - radius, 1e-3));
}

// Length from which on leaves are lit in each pixel: windfall_core::simplify::Simplification::lit_leaf_pixels.
fn lit_leaf_pixels(list: TreeList) -> f32 {
    return select(1e30, LIT_AT_VERTICES * list.leaf_pixels, (list.flags & 8u) != 0u);
}

// The rank at which leaves are gone; above it nothing is drawn.
fn fade_end(list: TreeList, level: Level) -> f32 {
    return level.lambda + select(level.radius, 0.0, (list.flags & 2u) != 0u);
}
