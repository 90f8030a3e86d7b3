// Places and lights small leaves on the twigs, a thread for each leaf.

// First part of the model, parts, first vertex of its quads.
@group(2) @binding(0) var<uniform> range: vec4<u32>;
// LeafVertex, LEAF_VERTEX_WORDS each.
@group(2) @binding(1) var<storage, read> leaf_vertices: array<u32>;
@group(2) @binding(2) var<storage, read> placed: array<TreeInstance>;
@group(2) @binding(3) var<storage, read> parts: array<vec4<u32>>;
@group(2) @binding(4) var<storage, read_write> quads: array<vec4<u32>>;

fn leaf_vertex(index: u32) -> LeafVertex {
    let at = LEAF_VERTEX_WORDS * index;
    let offset = vec2(leaf_vertices[at + 4u], leaf_vertices[at + 5u]);
    return LeafVertex(
        bitcast<vec3<f32>>(vec3(leaf_vertices[at], leaf_vertices[at + 1u], leaf_vertices[at + 2u])),
        leaf_vertices[at + 3u],
        vec4(unpack2x16float(offset.x), unpack2x16float(offset.y)),
        unpack4x8snorm(leaf_vertices[at + 6u]),
        unpack4x8snorm(leaf_vertices[at + 7u]),
        unpack2x16float(leaf_vertices[at + 8u]),
        leaf_vertices[at + 9u],
    );
}

// As the instance-step vertex buffer has it.
fn tree_at(place: u32) -> Tree {
    let t = placed[place];
    return Tree(
        vec4(t.position, t.scale),
        vec4(t.cos_yaw, t.sin_yaw, t.season_offset, t.lambda),
        vec4(t.fade_end, t.fade_slope, t.growth, t.contrast),
        vec4(t.seed, t.detached, t.wind, t.mean_cosines),
    );
}

// All corners of a leaf that is not there are the same: it has no area.
fn leave_out(quad: u32) {
    for (var i = 0u; i < 4u; i++) {
        quads[4u * quad + i] = vec4(0u);
    }
}

@compute @workgroup_size(64)
fn spread(@builtin(global_invocation_id) id: vec3<u32>) {
    let end = range.x + range.y;
    let quad = parts[range.x].x + id.x;
    if quad >= parts[end].x {
        return;
    }
    // The last part that begins at or before the quad: empty ones come before their followers.
    var low = range.x;
    var high = end;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if parts[middle].x <= quad {
            low = middle;
        } else {
            high = middle;
        }
    }
    let part = parts[low];
    let of_part = quad - part.x;
    let tree = tree_at(part.w + of_part / part.y);
    let first = part.z + 4u * (of_part % part.y);
    let leaf = leaf_vertex(first);
    let seen = leaf_seen(tree, leaf.leaf);
    if gone(leaf.leaf, leaf.material_shed & 0xffffffu, tree, seen) {
        leave_out(quad);
        return;
    }
    let size = tree.fade_growth.z * sqrt(seen);
    let hanging = hanging_leaf(leaf.center, leaf.bent_normal.z, size, tree);
    if hanging.form != SIMPLE {
        leave_out(quad);
        return;
    }
    // Lit once, in its middle; its corners have one normal.
    var corners: array<vec4<f32>, 4>;
    var middle: Varyings;
    var reach = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let at = LEAF_VERTEX_WORDS * (first + i);
        let offset = size * vec3(unpack2x16float(leaf_vertices[at + 4u]), unpack2x16float(leaf_vertices[at + 5u]).x);
        let corner = hanging_vertex(hanging, offset, leaf.normal.xyz, tree);
        corners[i] = corner.clip;
        middle.normal = corner.normal;
        reach += 0.25 * quarter_reach(hanging, offset, corner.normal, i, tree);
    }
    middle.world = hanging.at;
    var lit_leaf = leaf_alike(middle, leaf, tree, seen);
    lit_leaf.bent_normal_reach.w = reach;
    let radiance = pack_radiance(radiance_at_vertex(lit_leaf));
    for (var i = 0u; i < 4u; i++) {
        quads[4u * quad + i] = quad_corner(corners[i], radiance);
    }
}
