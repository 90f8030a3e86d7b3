// Poses an entry of the CPU's list: FallingLeaf as five vectors.

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
    return loose_leaf(leaf);
}
