// One tree: the instance-step vertex buffer.
struct Tree {
    @location(8) position_scale: vec4<f32>,
    // Cosine and sine of the yaw, season offset, share of leaves drawn.
    @location(9) turn_season: vec4<f32>,
    // Rank at which leaves are gone, one over the range over which they fade, factor on their length,
    // what is left of contrasts; where leaves are told apart, the tree's index in its place.
    @location(10) fade_growth: vec4<f32>,
    // Key of the tree; leaves of shed rank below the lower 24 bits have left; above them the root of the
    // tree's events. Wind at its foot, and mean cosines of the sun on its leaves, two halfs
    // each.
    @location(11) seed_detached_wind_cosines: vec4<u32>,
}

fn turn(tree: Tree, v: vec3<f32>) -> vec3<f32> {
    let c = tree.turn_season.x;
    let s = tree.turn_season.y;
    return vec3(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

// Where a point of the tree is in the wind.
fn world_from_tree(tree: Tree, v: vec3<f32>) -> vec3<f32> {
    let rest = tree.position_scale.xyz + turn(tree, v) * tree.position_scale.w;
    return rest + sway(rest, tree.position_scale.y);
}

// The same from so far that limbs and twigs are not seen to move: the whole tree leans.
fn world_from_far_tree(tree: Tree, v: vec3<f32>) -> vec3<f32> {
    let rest = tree.position_scale.xyz + turn(tree, v) * tree.position_scale.w;
    let lean = lean_of(unpack2x16float(tree.seed_detached_wind_cosines.z), max(rest.y - tree.position_scale.y, 0.0));
    return rest + frame.sway * vec3(lean.x, 0.0, lean.y);
}
