// A leaf that has left its twig, as it is drawn: in the air, settling, lying, withering, vanishing.
// The same for all strategies; the pass declares table(i).

// What is constant for the leaf.
struct LeafConstants {
    falls: LeafFall,
    // Where it lands, and seconds after the detachment.
    landing: vec4<f32>,
    lying: vec4<f32>,
    scale: f32,
    // Height over the ground at which it lies: leaves stand a little apart, so that none flickers in
    // another.
    stack: f32,
    // When it has become too many, seconds since the scene began.
    vanish_time: f32,
    // How far it is ahead of the season.
    ripe: f32,
    // As LooseLeaf.look, with the ambient light on the twig in the second byte and the bent normal
    // in the upper two.
    look: u32,
    model: u32,
}

// Seconds over which a lying leaf withers, and over which it is made small before another takes its
// place.
const WITHERING: f32 = 240.0;
const VANISHING: f32 = 6.0;
// Seconds over which the twig's motion goes out of a leaf that has left it.
const LETTING_GO: f32 = 1.5;
// Share of the ambient light that reaches a leaf that has left its tree.
const AMBIENT_IN_AIR: f32 = 0.9;
// Of leaves that lie, where leaves are coloured by the loops of their path (VB Figure 5).
const LANDED_COLOR = vec3<f32>(1.0, 0.16, 0.42);

// Green, yellow, blue, orange, violet and teal in turn, as LooseLeaf.color has them. Software drivers run both sides
// of every branch: a table of vectors, written to memory for each leaf, was an eighth of what a pose costs.
fn lap_color(lap: u32) -> u32 {
    let turn = lap % 6u;
    let first = select(select(0xa15a28u, 0x1f8ea1u, turn == 1u), 0x337928u, turn == 0u);
    let second = select(select(0x918c28u, 0x91336bu, turn == 4u), 0x1f5aa1u, turn == 3u);
    return select(second, first, turn < 3u);
}

fn stack_height(scale: f32, thickness: f32, key: u32) -> f32 {
    return scale * thickness + 0.002 + 0.012 * unit(hash(key, 13u));
}

fn withering(since_landing: f32) -> vec3<f32> {
    return mix(vec3(1.0), vec3(0.62, 0.48, 0.42), clamp(since_landing / WITHERING, 0.0, 1.0));
}

fn vanishing(vanish_time: f32) -> f32 {
    return clamp(-since(vanish_time) / VANISHING, 0.0, 1.0);
}

fn palette_color(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(table(i).rgb);
}

fn season_color(leaf: LeafConstants) -> vec3<f32> {
    let head = fall.model_table + (MODEL_HEAD + PALETTE) * leaf.model;
    let model = table(head); // colours of the palette, spread
    let season = season_of(leaf.falls.seed, leaf.ripe, bitcast<f32>(model.y));
    var color = vec3(season.brightness);
    let colors = model.x;
    if colors > 0u {
        let x = season.phase * f32(colors - 1u);
        let i = min(u32(x), colors - 2u);
        color *= mix(palette_color(head + MODEL_HEAD + i), palette_color(head + MODEL_HEAD + 1u + i), x - f32(i));
    }
    return color;
}

// Above the ground by `lift`, for a leaf that lies or will lie in this orientation.
fn lifted(position: vec3<f32>, lying: vec4<f32>, lift: f32) -> vec3<f32> {
    let up = quat_rotate(lying, vec3(0.0, 1.0, 0.0));
    return position + lift * select(-up, up, up.y >= 0.0);
}

fn loose_leaf(leaf: LeafConstants) -> LooseLeaf {
    let elapsed = since(leaf.falls.detach_time);
    var out: LooseLeaf;
    out.scale = leaf.scale;
    var position = leaf.landing.xyz;
    var orientation = leaf.lying;
    var lift = leaf.stack;
    var bend = 1.0;
    var color = season_color(leaf);
    if elapsed < leaf.landing.w {
        let variant = variant_of(leaf.falls.variant, leaf.falls.origin);
        let pose = falling_pose(leaf.falls, variant, leaf.landing.w, leaf.lying, elapsed);
        position = pose.position;
        orientation = pose.orientation;
        bend = pose.bend;
        // It leaves the twig where the wind has moved that, and takes its own way from there.
        let foot = ground_at(leaf.falls.origin.xz).height;
        let free = smooth_step(elapsed / min(LETTING_GO, leaf.landing.w));
        position += sway(leaf.falls.origin, foot) * (1.0 - free);
        orientation = quat_mul(flutter(leaf.falls.origin, 1.0 - free), orientation);
        let settle = settle_time(leaf.landing.w);
        lift *= smooth_step(1.0 - (leaf.landing.w - elapsed) / max(settle, 1e-30));
        if fall.color_loops == 1u {
            let root = unpack4x8unorm(lap_color(pose.lap)).rgb;
            color = 2.0 * root * root;
        }
    } else {
        out.scale *= vanishing(leaf.vanish_time);
        color *= withering(elapsed - leaf.landing.w);
        if fall.color_loops == 1u {
            color = LANDED_COLOR;
        }
    }
    out.position = lifted(position, leaf.lying, lift);
    out.orientation_xy = pack2x16snorm(orientation.xy);
    out.orientation_zw = pack2x16snorm(orientation.zw);
    let ambient = unpack4x8unorm(leaf.look).y;
    out.color = pack4x8unorm(vec4(sqrt(color * 0.5), mix(ambient, AMBIENT_IN_AIR, bend)));
    out.look = (leaf.look & 0xffu) | ((leaf.look >> 8u) & 0x00ffff00u)
        | (pack4x8unorm(vec4(0.0, 0.0, 0.0, bend)) & 0xff000000u);
    return out;
}
