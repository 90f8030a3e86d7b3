// What a view draws of the leaves that have left their twigs: those in view, with the level of detail of the trees
// that they are from.

@group(1) @binding(0) var<uniform> fall: FallFrame;
// How the view simplifies trees: loose leaves as those on the twigs that they are from.
@group(1) @binding(1) var<uniform> cull: CullFrame;
@group(1) @binding(2) var<storage, read> streams: array<Stream>;
// See falls.wgsl.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var<storage, read> models: array<Model>;
@group(1) @binding(5) var<storage, read> posed: array<LooseLeaf>;
@group(1) @binding(6) var<storage, read> work: array<vec4<u32>>;
// The leaves that are drawn: those of a draw from its first slot on, its small ones from its end down.
@group(1) @binding(7) var<storage, read_write> drawn: array<LooseLeaf>;
// See VIEW_TALLIES. Then the indirect arguments of the draws; those of their small leaves; two words a stream: see
// `levels`; a word for each group of slots to gather from.
@group(1) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;

const LIES: u32 = 2u;

fn arguments_at(bin: u32, small: bool) -> u32 {
    return VIEW_TALLIES + DRAW_WORDS * (bin + select(0u, fall.bin_count, small));
}

fn level_at(stream: u32) -> u32 {
    return VIEW_TALLIES + 2u * DRAW_WORDS * fall.bin_count + 2u * stream;
}

fn selected_at(i: u32) -> u32 {
    return level_at(fall.stream_count) + i;
}

// How the tree of a stream is drawn.
struct StreamLevel {
    // Leaf of the model from which on none is seen; one over the number of leaves that fade.
    fade_end: f32,
    fade_slope: f32,
    // Factor on a leaf's length.
    growth: f32,
}

fn level_of(stream: u32) -> StreamLevel {
    let at = level_at(stream);
    let fade = unpack2x16float(atomicLoad(&counters[at + 1u]));
    return StreamLevel(bitcast<f32>(atomicLoad(&counters[at])), fade.x, fade.y);
}

@compute @workgroup_size(BLOCK)
fn levels(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= fall.stream_count {
        return;
    }
    let stream = streams[id.x];
    let crown = models[stream.model].crown;
    let c = crown.center;
    let turned = vec3(
        stream.cos_yaw * c.x + stream.sin_yaw * c.z,
        c.y,
        stream.cos_yaw * c.z - stream.sin_yaw * c.x,
    );
    let list = cull.lists[0];
    let center = stream.position + turned * stream.scale;
    let level = tree_level(list, crown, stream.scale, center);
    let leaf_count = f32(stream.leaf_count);
    // Half floats end at 65,504: where fewer than a hundredth of a leaf fades, none does.
    let slope = min(0.5 / max(level.radius * leaf_count, 1e-6), 100.0);
    let at = level_at(id.x);
    atomicStore(&counters[at], bitcast<u32>(fade_end(list, level) * leaf_count));
    atomicStore(&counters[at + 1u], pack2x16float(vec2(slope, level.growth)));
}

// Groups of slots that may have leaves in view: all that hold any, but for those at rest elsewhere.
@compute @workgroup_size(BLOCK)
fn select_groups(@builtin(global_invocation_id) id: vec3<u32>) {
    let group = id.x;
    if group >= fall.group_count {
        return;
    }
    let stream = lists[2u * group];
    if lists[2u * group + 1u] >= work[WINDOW * stream].x {
        return;
    }
    let rest = rest_of(group);
    let leaf_radius = streams[stream].radius * rest.scale * level_of(stream).growth;
    if rest.there && !in_view(rest.middle, rest.radius + leaf_radius) {
        return;
    }
    let i = atomicAdd(&counters[2], 1u);
    atomicMax(&counters[3], min(i + 1u, ROW));
    atomicMax(&counters[4], i / ROW + 1u);
    atomicStore(&counters[selected_at(i)], group);
}

// A stream's leaves: see Window in falls.wgsl.
struct Window {
    detached: u32,
    newest: u32,
    slot_first: u32,
    keep: u32,
    // Whether they can be drawn in two triangles.
    simple: bool,
    bin: u32,
    radius: f32,
    list_first: u32,
    bin_first: u32,
    // Its tree's index in the forest.
    tree: u32,
}

fn window_of(stream: u32) -> Window {
    let at = WINDOW * stream;
    let a = work[at];
    let b = work[at + 1u];
    let d = work[at + 3u];
    return Window(a.x, a.z, a.w, b.x, b.y == 1u, b.z, bitcast<f32>(b.w), d.y, d.w, streams[stream].tree);
}

// What a leaf is drawn with of its size: 0 if its tree is drawn without it.
fn kept_size(level: StreamLevel, leaf: u32) -> f32 {
    let seen = clamp((level.fade_end - f32(leaf)) * level.fade_slope, 0.0, 1.0);
    return level.growth * sqrt(select(seen, seen * seen * (3.0 - 2.0 * seen), frame.fade_smooth == 1u));
}

fn in_view(position: vec3<f32>, radius: f32) -> bool {
    let at = vec4(position, 1.0);
    let list = cull.lists[0];
    let sides = min(
        min(dot(list.planes[0], at), dot(list.planes[1], at)),
        min(dot(list.planes[2], at), dot(list.planes[3], at)),
    );
    // What the camera does not see may yet cast shadows.
    return min(sides, dot(list.planes[4], at)) >= -radius || distance(position, list.eye) < cull.shadow_reach;
}

// Whether a leaf is so small in the picture that two triangles will do, as on its twig.
fn is_small(window: Window, leaf: LooseLeaf) -> bool {
    let list = cull.lists[0];
    let length = 2.0 * window.radius * leaf.scale * list.pixels;
    return window.simple && length < list.leaf_pixels * distance(leaf.position, list.eye);
}

struct Gathered {
    leaf: LooseLeaf,
    seen: bool,
    small: bool,
    in_air: bool,
}

fn gather_slot(window: Window, level: StreamLevel, there: bool, at: u32) -> Gathered {
    let back = window.newest - at + select(0u, window.keep, at > window.newest);
    let held = there && at < window.keep && back < window.detached;
    var leaf = posed[window.slot_first + select(0u, at, held)];
    let bits = bitcast<u32>(leaf.scale);
    let place = bits & 3u;
    let index = lists[window.list_first + select(0u, window.detached - 1u - back, held)];
    leaf.scale = bitcast<f32>(bits & ~3u) * kept_size(level, index);
    if frame.show == SHOW_IDS {
        leaf.color = index;
        leaf.look = (leaf.look & 0xffu) | (window.tree << 8u);
    }
    let seen = held && leaf.scale > 0.0 && in_view(leaf.position, window.radius * leaf.scale);
    return Gathered(leaf, seen, seen && is_small(window, leaf), place < LIES);
}

// How many leaves of the workgroup are drawn in full, drawn small, and drawn in the air, small or not: ten
// bits each.
var<workgroup> counts: atomic<u32>;
var<workgroup> full_first: u32;
var<workgroup> small_first: u32;

fn counted(gathered: Gathered) -> u32 {
    let drawn = select(1u, 0x400u, gathered.small) + select(0u, 0x100000u, gathered.in_air);
    return select(0u, drawn, gathered.seen);
}

// Where the next leaves are drawn from, in full and small, after this one.
fn put(gathered: Gathered, at: vec2<u32>) -> vec2<u32> {
    if !gathered.seen {
        return at;
    }
    drawn[select(at.x, at.y, gathered.small)] = gathered.leaf;
    return at + select(vec2(1u, 0u), vec2(0u, 1u), gathered.small);
}

@compute @workgroup_size(BLOCK)
fn gather(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    // None in the last row's end.
    let there = id.y * ROW + id.x < atomicLoad(&counters[2]);
    let listed = atomicLoad(&counters[selected_at(select(0u, id.y * ROW + id.x, there))]);
    let group = select(0u, listed, there);
    let stream = lists[2u * group];
    let window = window_of(stream);
    let level = level_of(stream);
    let first = lists[2u * group + 1u];
    let p0 = gather_slot(window, level, there, first + local);
    let p1 = gather_slot(window, level, there, first + BLOCK + local);
    let p2 = gather_slot(window, level, there, first + 2u * BLOCK + local);
    let p3 = gather_slot(window, level, there, first + 3u * BLOCK + local);
    let before = atomicAdd(&counts, counted(p0) + counted(p1) + counted(p2) + counted(p3));
    workgroupBarrier();
    if local == 0u {
        let all = atomicLoad(&counts);
        let full = all & 0x3ffu;
        let small = (all >> 10u) & 0x3ffu;
        atomicAdd(&counters[0], all >> 20u);
        atomicAdd(&counters[1], full + small - (all >> 20u));
        full_first = window.bin_first + atomicAdd(&counters[arguments_at(window.bin, false) + 1u], full);
        // From the end down.
        let at = arguments_at(window.bin, true);
        atomicAdd(&counters[at + 1u], small);
        small_first = window.bin_first + atomicSub(&counters[at + 4u], small) - small;
    }
    workgroupBarrier();
    var at = vec2(full_first + (before & 0x3ffu), small_first + ((before >> 10u) & 0x3ffu));
    at = put(p0, at);
    at = put(p1, at);
    at = put(p2, at);
    at = put(p3, at);
}
