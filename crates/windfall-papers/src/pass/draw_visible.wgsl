// Leaf occlusion: each vertex looks up what is done with its leaf.

@group(3) @binding(0) var actions: texture_2d<u32>;

// Whether skipped leaves are drawn, or all others.
override skipped: bool = false;

fn action_with(leaf: u32) -> u32 {
    return textureLoad(actions, vec2(leaf % BLOCK_SIZE, leaf / BLOCK_SIZE), 0).x;
}

fn drawn_leaf(vertex: Varyings, leaf: u32) -> Varyings {
    let action = action_with(leaf);
    var out = vertex;
    if (action == SKIP) != skipped {
        out.clip = NOWHERE;
    }
    if frame.show == SHOW_OCCLUSION {
        out.color = action_color(action);
        if lit_at_vertices {
            out.color = radiance_at_vertex(out);
        }
    }
    return out;
}

fn tested_leaf(vertex: Varyings, leaf: u32) -> Counted {
    var out = Counted(vertex.clip, vertex.uv, vertex.material, leaf);
    if action_with(leaf) != TEST {
        out.clip = NOWHERE;
    }
    return out;
}
