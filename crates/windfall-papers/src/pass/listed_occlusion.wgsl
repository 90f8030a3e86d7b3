// Leaf occlusion for the leaves that the CPU lists: what is to be done with each is looked up.

@group(3) @binding(0) var doings: texture_2d<u32>;

// Whether the leaves that are skipped are drawn, or all others.
override skipped: bool = false;

fn doing_with(place: u32) -> u32 {
    return textureLoad(doings, vec2(place & 255u, place >> 8u), 0).x;
}

fn watched_leaf(leaf: Varyings, place: u32) -> Varyings {
    let what = doing_with(place);
    var out = leaf;
    if (what == SKIP) != skipped {
        out.clip = NOWHERE;
    }
    if frame.show == SHOW_OCCLUSION {
        out.color = occlusion_color(what);
        if lit_at_vertices {
            out.bent_normal_reach = vec4(radiance_at_vertex(out), 1.0);
        }
    }
    return out;
}

fn counted_leaf(leaf: Varyings, place: u32) -> Counted {
    var out = counted(leaf, place);
    if doing_with(place) != TEST {
        out.clip = NOWHERE;
    }
    return out;
}
