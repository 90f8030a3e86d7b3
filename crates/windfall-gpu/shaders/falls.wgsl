// Leaves that have left their twigs, in the air and on the ground: landing, pose, compaction.

@group(1) @binding(0) var<uniform> fall: FallFrame;
@group(1) @binding(1) var table_texels: texture_2d<u32>;
@group(1) @binding(2) var<storage, read> streams: array<Stream>;
// For each workgroup of `pose` its stream, and the first of its slots there. Then the shed lists; behind
// those of thrown leaves when they detach.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var<storage, read> leaves: array<LeafRecord>;
@group(1) @binding(5) var<storage, read> models: array<Model>;
// Two vectors a slot. Of a leaf in the air: origin, moved by the wind at the detachment; time of the
// detachment; seconds to the landing; variant; colour with the upper byte of the size; look with the
// lower. Of a leaf that lies: place, time of the landing, orientation of which y is negative, colour and
// look.
@group(1) @binding(6) var<storage, read_write> slots: array<vec4<u32>>;
// The leaves that are drawn. With leaf occlusion two more lists of as many: those that are tested, those
// that are skipped.
@group(1) @binding(7) var<storage, read_write> drawn: array<LooseLeaf>;
// Five words a draw: its indirect arguments; then as many for the small leaves of the same draw, which
// fill its part of the list from the end. Then the tallies: leaves in the air, of those drawn,
// leaves on the ground, of those drawn, one unused; then how many slots `land` has to
// fill: in workgroups, 1, and in slots; then how many leaves `change` has to pose, in workgroups and in
// leaves; leaves that are tested, and that are skipped. With leaf occlusion then the arguments of the
// other two lists, and for each leaf that is tested its slot.
@group(1) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;

// How trees are simplified: loose leaves as those on the twigs that they are from.
@group(1) @binding(9) var<uniform> cull: CullFrame;
// Four vectors a stream: see Window. Then a word a slot: see changing_at. Then, with leaf occlusion,
// another: shared/sight.wgsl. Beside the slots, of which there are as many as a binding holds.
@group(1) @binding(10) var<storage, read_write> work: array<vec4<u32>>;

// Whether leaves are tested for being seen. Settled when the pipeline is made: without it nothing is paid.
override occlusion: bool = false;

// Workgroups in a row of a dispatch, and most of `land`.
const ROW: u32 = 32768u;
const SIGN: u32 = 0x80000000u;

// Which leaves of a stream have detached, and what all its leaves have in common, close together.
struct Window {
    detached: u32,
    // That will have when those that vanish now have vanished.
    soon: u32,
    // Local slot of the last that has.
    newest: u32,
    slot_first: u32,
    keep: u32,
    bin: u32,
    // Whether its leaves can be drawn in two triangles, and whether those on the tree are.
    simple: bool,
    tree_simple: bool,
    bin_first: u32,
    radius: f32,
    gusts: vec4<f32>,
    // Where its entries begin in the lists.
    list_first: u32,
    // Leaf of the model from which on none is seen; one over the number of leaves that fade.
    fade_end: f32,
    fade_slope: f32,
    // Factor on a leaf's length.
    growth: f32,
}

fn window_at(stream: u32) -> u32 {
    return 4u * stream;
}

fn window_of(stream: u32) -> Window {
    let at = window_at(stream);
    let a = work[at];
    let b = work[at + 1u];
    let d = work[at + 3u];
    let fade = unpack2x16float(d.w);
    return Window(
        a.x, a.y, a.z, a.w, b.x, b.y >> 2u, (b.y & 1u) == 1u, (b.y & 2u) == 2u, b.z, bitcast<f32>(b.w),
        bitcast<vec4<f32>>(work[at + 2u]), d.y, bitcast<f32>(d.z), fade.x, fade.y,
    );
}

// What the leaf of an entry is drawn with of its size: 0 if its tree is drawn without it.
fn kept_size(window: Window, entry: u32) -> f32 {
    let leaf = f32(lists[window.list_first + entry]);
    let seen = clamp((window.fade_end - leaf) * window.fade_slope, 0.0, 1.0);
    return window.growth * sqrt(select(seen, seen * seen * (3.0 - 2.0 * seen), frame.fade_smooth == 1u));
}

fn list_entry(stream: Stream, j: u32) -> u32 {
    return lists[2u * fall.group_count + stream.list_first + j];
}

// When the leaf of an entry detaches.
fn detach_of(stream: Stream, entry: u32) -> f32 {
    if stream.thrown == 1u {
        return bitcast<f32>(list_entry(stream, stream.list_count + entry));
    }
    let rank = leaves[stream.leaf_first + list_entry(stream, entry)].rank;
    return detach_time(stream.seed, stream.delay, stream.gust_phase, stream.leaf_count, rank);
}

// Entries of a stream that have detached by a time.
fn detached_entries(stream: Stream, time: f32) -> u32 {
    let detached = detached_by(time, stream.seed, stream.delay, stream.gust_phase, stream.leaf_count);
    var low = 0u;
    var high = stream.list_count;
    while low < high {
        let middle = (low + high) / 2u;
        var gone = leaves[stream.leaf_first + list_entry(stream, middle)].rank < detached;
        if stream.thrown == 1u {
            gone = detach_of(stream, middle) <= time;
        }
        if gone {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Counts the leaves of each stream that have detached.
@compute @workgroup_size(64)
fn windows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= fall.stream_count {
        return;
    }
    let stream = streams[id.x];
    let detached = detached_entries(stream, fall.time);
    let at = window_at(id.x);
    let known = select(work[at].x, 0u, fall.restart == 1u);
    work[at] = vec4(
        detached,
        detached_entries(stream, fall.time + VANISHING),
        (max(detached, 1u) - 1u) % stream.keep,
        stream.slot_first,
    );
    work[at + 2u] = bitcast<vec4<u32>>(gusts_at(wind_late(stream.position.xz), fall.time));
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
    let tree_simple = simple_leaves(list, crown, level, stream.scale, center);
    let bin = (stream.bin << 2u) | (u32(tree_simple) << 1u) | stream.simple;
    work[at + 1u] = vec4(stream.keep, bin, stream.bin_first, bitcast<u32>(stream.radius));
    let leaf_count = f32(stream.leaf_count);
    // Half floats end at 65,504: where fewer than a hundredth of a leaf fades, none does.
    let slope = min(0.5 / max(level.radius * leaf_count, 1e-6), 100.0);
    work[at + 3u] = vec4(
        known,
        2u * fall.group_count + stream.list_first,
        bitcast<u32>(fade_end(list, level) * leaf_count),
        pack2x16float(vec2(slope, level.growth)),
    );
}

fn leaf_fall(stream: Stream, entry: u32, record: LeafRecord) -> LeafFall {
    let at = record.center;
    let turned = vec3(
        stream.cos_yaw * at.x + stream.sin_yaw * at.z,
        at.y,
        stream.cos_yaw * at.z - stream.sin_yaw * at.x,
    );
    let half_angle = vec2(sqrt(max(0.5 + 0.5 * stream.cos_yaw, 0.0)), sqrt(max(0.5 - 0.5 * stream.cos_yaw, 0.0)));
    let yaw = vec4(0.0, select(-half_angle.y, half_angle.y, stream.sin_yaw >= 0.0), 0.0, half_angle.x);
    let own = normalize(vec4(unpack2x16snorm(record.orientation_xy), unpack2x16snorm(record.orientation_zw)));
    var out: LeafFall;
    out.origin = stream.position + turned * stream.scale;
    out.twig = quat_mul(yaw, own);
    out.seed = hash(stream.seed, record.rank);
    out.variant = draw_variant(out.seed, stream.path_group, out.origin);
    out.late = wind_late(stream.position.xz);
    out.detach_time = detach_of(stream, entry);
    return out;
}

// Lists the entries that have detached since the last frame, or all that are kept after a seek; a
// workgroup for each stream. The list is kept in `drawn`, which nothing else uses yet.
@compute @workgroup_size(64)
fn find(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let stream = group.y * ROW + group.x;
    if stream >= fall.stream_count {
        return;
    }
    let at = window_at(stream);
    let end = work[at].x;
    let keep = work[at + 1u].x;
    for (var j = max(work[at + 3u].x, end - min(keep, end)) + local; j < end; j += 64u) {
        let i = atomicAdd(&counters[tallies() + 7u], 1u);
        drawn[i].color = stream;
        drawn[i].look = j;
        if i % 64u == 0u && i < 64u * ROW {
            atomicAdd(&counters[tallies() + 5u], 1u);
        }
    }
}

// Finds where the leaves of the listed entries will land, and fills their slots.
@compute @workgroup_size(64)
fn land(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = atomicLoad(&counters[tallies() + 7u]);
    for (var i = id.x; i < count; i += 64u * ROW) {
        let stream = streams[drawn[i].color];
        let entry = drawn[i].look;
        var leaf = leaf_constants(stream, entry);
        leaf.landing.w = landing_time(leaf.falls, variant_of(leaf.falls.variant, leaf.falls.origin));
        let slot = stream.slot_first + entry % stream.keep;
        fill(slot, leaf);
        if occlusion {
            forget_sight(slot);
        }
    }
}

fn in_the_air(leaf: LeafConstants) -> bool {
    return fall.time - leaf.falls.detach_time < leaf.landing.w;
}

// Finds where and how the leaf lies, from the time of its landing.
fn lie_down(leaf: ptr<function, LeafConstants>) {
    let variant = variant_of((*leaf).falls.variant, (*leaf).falls.origin);
    let landing = landing_at((*leaf).falls, variant, (*leaf).landing.w);
    (*leaf).landing = vec4(landing.position, landing.time);
    (*leaf).lying = landing.orientation;
}

// Colour and look as slots have them.
fn packed_colors(leaf: LeafConstants) -> vec2<u32> {
    let size = pack2x16float(vec2(leaf.scale, 0.0));
    return vec2(
        (pack4x8unorm(vec4(sqrt(season_color(leaf) * 0.5), 0.0)) & 0xffffffu) | ((size >> 8u) << 24u),
        (leaf.look & 0xffu) | ((leaf.look >> 8u) & 0xffff00u) | (size << 24u),
    );
}

fn fill(slot: u32, constants: LeafConstants) {
    var leaf = constants;
    let colors = packed_colors(leaf);
    if in_the_air(leaf) {
        let blown = wind_at_detachment(leaf.falls.late, leaf.falls.detach_time);
        let origin = leaf.falls.origin + vec3(blown.x, 0.0, blown.y);
        slots[2u * slot] = bitcast<vec4<u32>>(vec4(origin, leaf.falls.detach_time));
        slots[2u * slot + 1u] = vec4(bitcast<u32>(leaf.landing.w), leaf.falls.variant, colors);
        return;
    }
    lie_down(&leaf);
    let q = select(leaf.lying, -leaf.lying, leaf.lying.y > 0.0);
    slots[2u * slot] = bitcast<vec4<u32>>(vec4(
        lifted(leaf.landing.xyz, q, leaf.stack),
        leaf.falls.detach_time + leaf.landing.w,
    ));
    slots[2u * slot + 1u] = vec4(
        pack2x16snorm(vec2(q.x, min(q.y, -1.0 / 32767.0))),
        pack2x16snorm(q.zw),
        colors,
    );
}

fn in_view(position: vec3<f32>, radius: f32) -> bool {
    let at = vec4(position, 1.0);
    let sides = min(
        min(dot(fall.frustum[0], at), dot(fall.frustum[1], at)),
        min(dot(fall.frustum[2], at), dot(fall.frustum[3], at)),
    );
    return min(sides, dot(fall.frustum[4], at)) >= -radius || distance(position, frame.eye) < fall.shadow_reach;
}

// What is constant for the leaf of an entry, but for its landing.
fn leaf_constants(stream: Stream, entry: u32) -> LeafConstants {
    let leaf = list_entry(stream, entry);
    let record = leaves[stream.leaf_first + leaf];
    var out: LeafConstants;
    out.falls = leaf_fall(stream, entry, record);
    out.scale = record.scale * stream.scale;
    out.stack = stack_height(out.scale, stream.thickness, out.falls.seed);
    let from_center = (record.center - models[stream.model].crown_center) / models[stream.model].crown_extent;
    out.ripe = ripeness(stream.season_offset, from_center.y) + branch_ripeness(stream.seed, from_center);
    let bent = from_octahedral(unpack4x8snorm(record.look).zw);
    let turned = vec3(
        stream.cos_yaw * bent.x + stream.sin_yaw * bent.z,
        bent.y,
        stream.cos_yaw * bent.z - stream.sin_yaw * bent.x,
    );
    let ambient = unpack4x8unorm(record.look).y;
    out.look = (record.look & 0xffu)
        | (pack4x8unorm(vec4(0.0, ambient, 0.0, 0.0)) & 0xff00u)
        | (pack4x8snorm(vec4(0.0, 0.0, octahedral(turned))) & 0xffff0000u);
    out.model = stream.model;
    out.vanish_time = 1e30;
    return out;
}

// When the leaf of an entry has to be gone: another takes its slot.
fn vanish_time(stream: Stream, entry: u32) -> f32 {
    let next = entry + stream.keep;
    if next >= stream.list_count {
        return 1e30;
    }
    return detach_of(stream, next);
}

// A leaf that leaves its twig, settles, has landed since the last frame, or vanishes: all that is seldom.
fn changing_leaf(stream_index: u32, slot: u32, entry: u32, gusts: vec4<f32>) -> LooseLeaf {
    let stream = streams[stream_index];
    var leaf = leaf_constants(stream, entry);
    var lies = (slots[2u * slot + 1u].x & SIGN) != 0u;
    leaf.landing.w = bitcast<f32>(slots[2u * slot + 1u].x);
    if !lies && (!in_the_air(leaf) || fall.recolor == 1u) {
        fill(slot, leaf);
        lies = !in_the_air(leaf);
    }
    if lies {
        slots[2u * slot + 1u].z = packed_colors(leaf).x;
        var out = lying_leaf(bitcast<vec4<f32>>(slots[2u * slot]), slots[2u * slot + 1u]);
        out.scale *= vanishing(vanish_time(stream, entry));
        return out;
    }
    let settles = fall.time - leaf.falls.detach_time > leaf.landing.w - settle_time(leaf.landing.w);
    let a = bitcast<vec4<f32>>(slots[2u * slot]);
    let b = slots[2u * slot + 1u];
    let variant = variant_of(b.y, a.xyz);
    let flight = flight_of(variant.flight);
    if !settles && fall.paper_variation == 0u && !near_twig(flight, variant, fall.time - a.w) {
        return flying_leaf(a, b, flight, variant, gusts); // it has only another colour
    }
    if settles {
        lie_down(&leaf);
    }
    return loose_leaf(leaf);
}

// Until a leaf has its path's orientation, and the twig's motion has gone out of it.
fn near_twig(flight: Flight, variant: Variant, elapsed: f32) -> bool {
    return path_time(variant, elapsed) * flight.rate < f32(flight.soft)
        || (frame.sway > 0.0 && elapsed < LETTING_GO);
}

fn slot_size(b: vec4<u32>) -> f32 {
    return unpack2x16float((b.w >> 24u) | ((b.z >> 24u) << 8u)).x;
}

fn shaded(color: vec3<f32>) -> u32 {
    return pack4x8unorm(vec4(color, AMBIENT_IN_AIR));
}

fn lying_leaf(a: vec4<f32>, b: vec4<u32>) -> LooseLeaf {
    var color = unpack4x8unorm(b.z).rgb * sqrt(withering(fall.time - a.w));
    if fall.show == SHOW_LAPS {
        color = sqrt(LANDED_COLOR * 0.5);
    }
    return LooseLeaf(a.xyz, slot_size(b), b.x, b.y, shaded(color), b.w | 0xff000000u);
}

// A leaf on its path, neither near its twig nor near the ground.
fn flying_leaf(a: vec4<f32>, b: vec4<u32>, flight: Flight, variant: Variant, gusts: vec4<f32>) -> LooseLeaf {
    let elapsed = fall.time - a.w;
    let free = way(flight, variant, elapsed);
    let blown = wind_since(elapsed, gusts);
    var color = b.z;
    if fall.show == SHOW_LAPS {
        color = lap_color(free.lap);
    }
    return LooseLeaf(
        a.xyz + free.displacement + vec3(blown.x, 0.0, blown.y),
        slot_size(b),
        pack2x16snorm(free.orientation.xy),
        pack2x16snorm(free.orientation.zw),
        (color & 0xffffffu) | pack4x8unorm(vec4(0.0, 0.0, 0.0, AMBIENT_IN_AIR)),
        b.w | 0xff000000u,
    );
}

// How many leaves of the workgroup are drawn in full, drawn small, and drawn in the air, small or not: ten
// bits each. How many are held in the air.
var<workgroup> counts: atomic<u32>;
var<workgroup> held_in_air: atomic<u32>;
var<workgroup> full_first: u32;
var<workgroup> small_first: u32;

fn tallies() -> u32 {
    return 10u * fall.bin_count;
}

// Whether a leaf is so small in the picture that two triangles will do. As its tree's leaves hang, so it lets
// go: `free` is whether it has.
fn is_small(window: Window, leaf: LooseLeaf, free: bool) -> bool {
    let list = cull.lists[0];
    let length = 2.0 * window.radius * leaf.scale * list.pixels;
    let short = length < list.leaf_pixels * distance(leaf.position, list.eye);
    return window.simple && short && (free || window.tree_simple);
}

// Where small leaves of a draw are added: below the last.
fn add_small(window: Window, count: u32) -> u32 {
    let arguments = 5u * (fall.bin_count + window.bin);
    atomicAdd(&counters[arguments + 1u], count);
    return window.bin_first + atomicSub(&counters[arguments + 4u], count) - count;
}

// Where the changing leaves are listed, four a vector: workgroup of `pose`, and which of its slots.
fn changing_at(i: u32) -> u32 {
    return 4u * fall.stream_count + i / 4u;
}

fn forget_sight(slot: u32) {
    work[fall.sight_first + slot / 4u][slot % 4u] = 0u;
}

// What is to be done with a leaf that is in the air and in view.
fn watch(slot: u32) -> u32 {
    let at = fall.sight_first + slot / 4u;
    let sight = next_sight(work[at][slot % 4u], slot);
    work[at][slot % 4u] = sight;
    return done_with(sight);
}

// Adds a leaf that is tested or skipped to the list of those.
fn add_watched(leaf: LooseLeaf, what: u32, window: Window, slot: u32) {
    let arguments = tallies() + TALLIES + 5u * ((what - 1u) * fall.bin_count + window.bin);
    let at = window.bin_first + atomicAdd(&counters[arguments + 1u], 1u);
    drawn[what * fall.slot_count + at] = leaf;
    if what == TEST {
        atomicStore(&counters[tallies() + TALLIES + 10u * fall.bin_count + at], slot);
        atomicAdd(&counters[tallies() + 1u], 1u);
        atomicAdd(&counters[tallies() + 10u], 1u);
    } else {
        atomicAdd(&counters[tallies() + 11u], 1u);
    }
}

fn mark_sight(leaf: ptr<function, LooseLeaf>, what: u32) {
    if fall.show == SHOW_OCCLUSION {
        (*leaf).color = shaded(sqrt(occlusion_color(what) * 0.5));
    }
}

// How many entries the leaf in local slot `at` is behind the last that detached.
fn entries_back(window: Window, at: u32) -> u32 {
    return window.newest - at + select(0u, window.keep, at > window.newest);
}

// A leaf as `pose` leaves it: whether it is held in the air, whether it is drawn yet, and small.
struct Posed {
    leaf: LooseLeaf,
    in_air: bool,
    seen: bool,
    small: bool,
}

// Poses the leaf in local slot `at` of a stream if it flies or lies. If it changes, it is listed for `change`.
fn pose_slot(window: Window, index: u32, at: u32) -> Posed {
    let back = entries_back(window, at);
    let held = at < window.keep && back < window.detached;
    let slot = window.slot_first + select(0u, at, held);
    let a = bitcast<vec4<f32>>(slots[2u * slot]);
    let b = slots[2u * slot + 1u];
    let lies = (b.x & SIGN) != 0u;
    let elapsed = fall.time - a.w;
    let landing = bitcast<f32>(b.x);
    let vanishes = window.detached - 1u - back + window.keep < window.soon;
    var changes = held && (fall.recolor == 1u || vanishes || (!lies && elapsed > landing - settle_time(landing)));
    let in_air = held && !lies && elapsed < landing;
    var leaf: LooseLeaf;
    if lies {
        leaf = lying_leaf(a, b);
    } else {
        let variant = variant_of(b.y, a.xyz);
        let flight = flight_of(variant.flight);
        // The paper's variation follows from the leaf's place on the twig, which slots do not hold.
        let slow = fall.paper_variation == 1u || near_twig(flight, variant, elapsed);
        changes = changes || (held && slow);
        leaf = flying_leaf(a, b, flight, variant, window.gusts);
    }
    if changes {
        let i = atomicAdd(&counters[tallies() + 9u], 1u);
        work[changing_at(i)][i % 4u] = index * GROUP + at % GROUP;
        if i % 64u == 0u && i < 64u * ROW {
            atomicAdd(&counters[tallies() + 8u], 1u);
        }
    }
    leaf.scale *= kept_size(window, select(0u, window.detached - 1u - back, held));
    var seen = held && !changes && leaf.scale > 0.0 && in_view(leaf.position, window.radius * leaf.scale);
    if occlusion && !changes && in_air {
        if seen {
            let what = watch(slot);
            mark_sight(&leaf, what);
            if what != SHOW {
                add_watched(leaf, what, window, slot);
                seen = false;
            }
        } else {
            forget_sight(slot);
        }
    }
    return Posed(leaf, in_air, seen, seen && is_small(window, leaf, lies || elapsed > LETTING_GO));
}

// The leaf's part of `counts`.
fn counted(posed: Posed) -> u32 {
    let drawn = select(1u, 0x400u, posed.small) + select(0u, 0x100000u, posed.in_air);
    return select(0u, drawn, posed.seen);
}

// Poses the leaves that fly and those that lie, and gathers those in view for drawing. Leaves that
// change are listed for `change`: few at a time, and costlier. A thread has several slots, a workgroup's
// size apart: what they have in common is read once.
@compute @workgroup_size(64)
fn pose(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let index = group.y * ROW + group.x;
    if index >= fall.group_count {
        return;
    }
    let window = window_of(lists[2u * index]);
    let first = lists[2u * index + 1u];
    let p0 = pose_slot(window, index, first + local);
    let p1 = pose_slot(window, index, first + 64u + local);
    let p2 = pose_slot(window, index, first + 128u + local);
    let p3 = pose_slot(window, index, first + 192u + local);
    let before = atomicAdd(&counts, counted(p0) + counted(p1) + counted(p2) + counted(p3));
    atomicAdd(&held_in_air, u32(p0.in_air) + u32(p1.in_air) + u32(p2.in_air) + u32(p3.in_air));
    workgroupBarrier();
    if local == 0u {
        let all = atomicLoad(&counts);
        let full = all & 0x3ffu;
        let small = (all >> 10u) & 0x3ffu;
        let in_air = atomicLoad(&held_in_air);
        // The first so many slots hold leaves.
        let held = min(window.keep, window.detached);
        let held_here = min(held - min(first, held), GROUP);
        atomicAdd(&counters[tallies()], in_air);
        atomicAdd(&counters[tallies() + 1u], all >> 20u);
        atomicAdd(&counters[tallies() + 2u], held_here - in_air);
        atomicAdd(&counters[tallies() + 3u], full + small - (all >> 20u));
        full_first = window.bin_first + atomicAdd(&counters[5u * window.bin + 1u], full);
        small_first = add_small(window, small);
    }
    workgroupBarrier();
    var at = vec2(full_first + (before & 0x3ffu), small_first + ((before >> 10u) & 0x3ffu));
    at = put(p0, at);
    at = put(p1, at);
    at = put(p2, at);
    at = put(p3, at);
}

// Where the next leaves are drawn from, in full and small, after this one.
fn put(posed: Posed, at: vec2<u32>) -> vec2<u32> {
    if !posed.seen {
        return at;
    }
    drawn[select(at.x, at.y, posed.small)] = posed.leaf;
    return at + select(vec2(1u, 0u), vec2(0u, 1u), posed.small);
}

// Poses the listed leaves: those that leave their twigs, settle, have just landed, or vanish.
@compute @workgroup_size(64)
fn change(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = atomicLoad(&counters[tallies() + 9u]);
    for (var i = id.x; i < count; i += 64u * ROW) {
        let listed = work[changing_at(i)][i % 4u];
        let stream = lists[2u * (listed / GROUP)];
        let window = window_of(stream);
        let at = lists[2u * (listed / GROUP) + 1u] + listed % GROUP;
        let slot = window.slot_first + at;
        let entry = window.detached - 1u - entries_back(window, at);
        var out = changing_leaf(stream, slot, entry, window.gusts);
        out.scale *= kept_size(window, entry);
        let on_ground = (slots[2u * slot + 1u].x & SIGN) != 0u;
        if out.scale > 0.0 && in_view(out.position, window.radius * out.scale) {
            if occlusion && !on_ground {
                let what = watch(slot);
                mark_sight(&out, what);
                if what != SHOW {
                    add_watched(out, what, window, slot);
                    continue;
                }
            }
            atomicAdd(&counters[tallies() + select(1u, 3u, on_ground)], 1u);
            let free = on_ground || fall.time - bitcast<f32>(slots[2u * slot].w) > LETTING_GO;
            if is_small(window, out, free) {
                drawn[add_small(window, 1u)] = out;
            } else {
                drawn[window.bin_first + atomicAdd(&counters[5u * window.bin + 1u], 1u)] = out;
            }
        } else if occlusion && !on_ground {
            forget_sight(slot);
        }
    }
}
