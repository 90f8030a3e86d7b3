// Poses an entry of the CPU's list: FallingLeaf as five vectors.

// Whether the landing is searched here, in every frame (VB 5), because the CPU has not.
override search_landing: bool = false;

fn active_leaf(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<u32>, e: vec4<u32>) -> LooseLeaf {
    let sizes = unpack2x16float(e.w);
    var leaf: LeafConstants;
    leaf.falls.origin = a.xyz;
    leaf.falls.detach_time = a.w;
    leaf.landing = b;
    leaf.falls.late = c.x;
    leaf.model = u32(c.y);
    leaf.vanish_time = c.z;
    leaf.ripe = c.w;
    leaf.falls.twig = normalize(vec4(unpack2x16snorm(d.x), unpack2x16snorm(d.y)));
    leaf.lying = normalize(vec4(unpack2x16snorm(d.z), unpack2x16snorm(d.w)));
    leaf.falls.seed = e.x;
    leaf.look = e.y;
    leaf.falls.variant = e.z;
    leaf.scale = sizes.x;
    leaf.stack = sizes.y;
    if search_landing {
        leaf = with_landing(leaf);
    }
    return loose_leaf(leaf);
}

// Where the leaf lands, if that may be soon or before: a binary search (VB 5). Later landings are not looked for.
fn with_landing(leaf: LeafConstants) -> LeafConstants {
    var out = leaf;
    let variant = variant_of(leaf.falls.variant, leaf.falls.origin);
    let flight = flight_of(variant.flight);
    let soonest = first_time_at(flight, variant, leaf.falls.origin.y - fall.ground_highest);
    if since(leaf.falls.detach_time) + max(fall.settle_time, 0.0) >= soonest {
        let landing = landing_at(leaf.falls, variant, landing_time(leaf.falls, variant));
        out.landing = vec4(landing.position, landing.time);
        out.lying = landing.orientation;
    }
    return out;
}
