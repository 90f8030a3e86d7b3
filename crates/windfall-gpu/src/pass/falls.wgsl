// Leaves that have left their twigs, in the air and on the ground: where they land, and where they are. Once a
// frame for all views of the forest; `gather.wgsl` has what a view draws of them.

@group(1) @binding(0) var<uniform> fall: FallFrame;
@group(1) @binding(1) var table_texels: texture_2d<u32>;
@group(1) @binding(2) var<storage, read> streams: array<Stream>;
// For each workgroup of `pose` its stream, and the first of its slots there. Then the shed lists; behind
// those of thrown leaves when they detach.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var<storage, read> leaves: array<LeafRecord>;
// Two vectors a slot. Of a leaf in the air: origin, moved by the wind at the detachment; time of the
// detachment; seconds to the landing; variant; colour with the upper byte of the size; look with the
// lower. Of a leaf that lies: place, time of the landing, orientation of which y is negative, colour and
// look. Size 0: a leaf that a program has thrown, and that is not of this stream.
@group(1) @binding(5) var<storage, read_write> slots: array<vec4<u32>>;
// A leaf a slot, as it is drawn: what views gather from. Of leaves that have withered it stays as it is.
@group(1) @binding(6) var<storage, read_write> posed: array<LooseLeaf>;
// WINDOW vectors a stream: see Window. Then a word a slot: leaves that `solve_landings` or `transition` has to see to.
// Then two vectors a group of slots: see rest.wgsl. Then a word a group: those that come to rest.
@group(1) @binding(7) var<storage, read_write> work: array<vec4<u32>>;
// See windfall_gpu::scene::falls::Counter.
@group(1) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;

const SIGN: u32 = 0x80000000u;
// Time of the landing of a leaf that has withered and been posed for good.
const SETTLED: f32 = -1e30;

// Counters.
const IN_AIR: u32 = 0u;
const ON_GROUND: u32 = 1u;
const LANDINGS: u32 = 2u;
const LANDING_GROUPS: u32 = 3u;
const CHANGES: u32 = 4u;
const CHANGE_GROUPS: u32 = 5u;
// Groups of slots that come to rest, workgroups in a row for them, rows.
const CALM: u32 = 6u;
// Groups of slots in which leaves were posed.
const AWAKE: u32 = 9u;

// Where a leaf is, in the lowest bits of LooseLeaf.scale.
const LETS_GO: u32 = 0u;
const FLIES: u32 = 1u;
const LIES: u32 = 2u;

// Which leaves of a stream have detached, and what all its leaves have in common, close together.
struct Window {
    detached: u32,
    // That will have when those that vanish now have vanished.
    soon: u32,
    // Local slot of the last that has.
    newest: u32,
    slot_first: u32,
    keep: u32,
    gusts: vec4<f32>,
    // Whether the season has changed and leaves need other colours.
    recolor: bool,
}

fn window_of(stream: u32) -> Window {
    let at = WINDOW * stream;
    let a = work[at];
    let b = work[at + 1u];
    let d = work[at + 3u];
    return Window(a.x, a.y, a.z, a.w, b.x, bitcast<vec4<f32>>(work[at + 2u]), d.z == 1u);
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

// Entries of a stream that have detached `ahead` seconds after the moment of the frame.
fn detached_entries(stream: Stream, ahead: f32) -> u32 {
    let detached = detached_by(ahead, stream.seed, stream.delay, stream.gust_phase, stream.leaf_count);
    var low = 0u;
    var high = stream.list_count;
    while low < high {
        let middle = (low + high) / 2u;
        var gone = leaves[stream.leaf_first + list_entry(stream, middle)].rank < detached;
        if stream.thrown == 1u {
            gone = since(detach_of(stream, middle)) >= -ahead;
        }
        if gone {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Counts the leaves of each stream that have detached. What the slots hold is known by the last vector, which
// the GPU alone writes: whatever frames a host records and does not submit, slots and vector agree.
@compute @workgroup_size(BLOCK)
fn update_windows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= fall.stream_count {
        return;
    }
    let stream = streams[id.x];
    let at = WINDOW * id.x;
    let state = work[at + 4u];
    let passed = (fall.time - bitcast<f32>(state.x)) + (fall.time_low - bitcast<f32>(state.y));
    let restart = state.z != fall.generation || passed < 0.0;
    let look = bitcast<u32>(frame.season) ^ (fall.color_loops << 31u);
    let known = select(work[at].x, 0u, restart);
    let detached = detached_entries(stream, 0.0);
    work[at] = vec4(
        detached,
        detached_entries(stream, VANISHING),
        (max(detached, 1u) - 1u) % max(stream.keep, 1u),
        stream.slot_first,
    );
    work[at + 1u] = vec4(stream.keep, stream.simple, stream.bin, bitcast<u32>(stream.radius));
    work[at + 2u] = bitcast<vec4<u32>>(gusts_at(wind_late(stream.position.xz), fall.clock));
    work[at + 3u] = vec4(known, 2u * fall.group_count + stream.list_first, u32(!restart && look != state.w), stream.bin_first);
    work[at + 4u] = vec4(bitcast<u32>(fall.time), bitcast<u32>(fall.time_low), fall.generation, look);
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

// The place of a word in the list of leaves that have to be seen to.
fn listed_at(i: u32) -> u32 {
    return WINDOW * fall.stream_count + i / 4u;
}

// A leaf in that list: workgroup of `pose`, and which of its slots.
struct Listed {
    stream: u32,
    // Its slot in the stream.
    at: u32,
}

fn listed(i: u32) -> Listed {
    let word = work[listed_at(i)][i % 4u];
    let group = word / GROUP;
    return Listed(lists[2u * group], lists[2u * group + 1u] + word % GROUP);
}

fn calm_at(i: u32) -> u32 {
    return rest_at(fall.group_count) + i / 4u;
}

// Lists a group of slots that comes to rest, and a workgroup for it.
fn add_calm(group: u32) {
    let i = atomicAdd(&counters[CALM], 1u);
    atomicMax(&counters[CALM + 1u], min(i + 1u, ROW));
    atomicMax(&counters[CALM + 2u], i / ROW + 1u);
    work[calm_at(i)][i % 4u] = group;
}

// Wakes groups of slots into which an entry detaches or is about to. Those at rest, where every leaf has withered and was
// posed for good, are counted here, and not posed.
@compute @workgroup_size(BLOCK)
fn wake(@builtin(global_invocation_id) id: vec3<u32>) {
    let group = id.x;
    if group >= fall.group_count {
        return;
    }
    let at = WINDOW * lists[2u * group];
    let soon = work[at].y;
    let known = work[at + 3u].x;
    let recolor = work[at + 3u].z == 1u;
    let rest = rest_of(group);
    if rest.there && known > 0u && !recolor && soon <= rest.until {
        atomicAdd(&counters[ON_GROUND], rest.leaves);
        return;
    }
    work[rest_at(group) + 1u].y = 0u;
    atomicAdd(&counters[AWAKE], select(0u, 1u, lists[2u * group + 1u] < work[at].x));
}

// Lists the entries that have detached since the last frame, or all that are kept after a seek; a
// workgroup for each stream.
@compute @workgroup_size(BLOCK)
fn collect_detached(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let stream = group.y * ROW + group.x;
    if stream >= fall.stream_count {
        return;
    }
    let at = WINDOW * stream;
    let end = work[at].x;
    let keep = work[at + 1u].x;
    let group_first = streams[stream].group_first;
    for (var j = max(work[at + 3u].x, end - min(keep, end)) + local; j < end; j += BLOCK) {
        let i = atomicAdd(&counters[LANDINGS], 1u);
        let slot = j % keep;
        work[listed_at(i)][i % 4u] = (group_first + slot / GROUP) * GROUP + slot % GROUP;
        if i % BLOCK == 0u && i < BLOCK * ROW {
            atomicAdd(&counters[LANDING_GROUPS], 1u);
        }
    }
}

// Finds where the leaves of the listed entries will land, and fills their slots.
@compute @workgroup_size(BLOCK)
fn solve_landings(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = atomicLoad(&counters[LANDINGS]);
    for (var i = id.x; i < count; i += BLOCK * ROW) {
        let leaf_at = listed(i);
        let stream = streams[leaf_at.stream];
        let window = window_of(leaf_at.stream);
        let entry = window.detached - 1u - entries_back(window, leaf_at.at);
        let slot = stream.slot_first + leaf_at.at;
        var leaf = leaf_constants(stream, entry);
        if stream.events == 1u && stream.thrown == 0u {
            let key = scripted_key(stream.seed, stream.position);
            if scripted_detach(key, list_entry(stream, entry)) < leaf.falls.detach_time {
                leave_out(slot);
                continue;
            }
        }
        leaf.landing.w = landing_time(leaf.falls, variant_of(leaf.falls.variant, leaf.falls.origin));
        fill(slot, leaf);
    }
}

fn in_the_air(leaf: LeafConstants) -> bool {
    return since(leaf.falls.detach_time) < leaf.landing.w;
}

// Finds where and how the leaf lies, from the time of its landing.
fn lie_down(leaf: ptr<function, LeafConstants>) {
    let variant = variant_of((*leaf).falls.variant, (*leaf).falls.origin);
    let landing = landing_at((*leaf).falls, variant, (*leaf).landing.w);
    (*leaf).landing = vec4(landing.position, landing.time);
    (*leaf).lying = landing.orientation;
}

// A leaf that is not of this stream.
fn leave_out(slot: u32) {
    slots[2u * slot] = bitcast<vec4<u32>>(vec4(0.0, 0.0, 0.0, SETTLED));
    slots[2u * slot + 1u] = vec4(SIGN, 0u, 0u, 0u);
    posed[slot] = LooseLeaf(vec3(0.0), 0.0, 0u, 0u, 0u, 0u);
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

// What is constant for the leaf of an entry, but for its landing.
fn leaf_constants(stream: Stream, entry: u32) -> LeafConstants {
    let leaf = list_entry(stream, entry);
    let record = leaves[stream.leaf_first + leaf];
    let head = fall.model_table + (MODEL_HEAD + PALETTE) * stream.model;
    let crown_center = bitcast<vec3<f32>>(table(head + 1u).xyz);
    let crown_extent = bitcast<vec3<f32>>(table(head + 2u).xyz);
    var out: LeafConstants;
    out.falls = leaf_fall(stream, entry, record);
    out.scale = record.scale * stream.scale;
    out.stack = stack_height(out.scale, stream.thickness, out.falls.seed);
    let from_center = (record.center - crown_center) / crown_extent;
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
    out.vanish_time = NEVER;
    return out;
}

// When the leaf of an entry has to be gone: another takes its slot.
fn vanish_time(stream: Stream, entry: u32) -> f32 {
    let next = entry + stream.keep;
    if next >= stream.list_count {
        return NEVER;
    }
    return detach_of(stream, next);
}

// A leaf with where it is.
fn located(leaf: LooseLeaf, place: u32) -> LooseLeaf {
    var out = leaf;
    out.scale = bitcast<f32>((bitcast<u32>(leaf.scale) & ~3u) | place);
    return out;
}

fn place_in_air(elapsed: f32) -> u32 {
    return select(LETS_GO, FLIES, elapsed > LETTING_GO);
}

// A leaf that leaves its twig, settles, has landed since the last frame, or vanishes: all that is seldom.
fn changing_leaf(stream_index: u32, slot: u32, entry: u32, window: Window) -> LooseLeaf {
    let stream = streams[stream_index];
    var leaf = leaf_constants(stream, entry);
    var lies = (slots[2u * slot + 1u].x & SIGN) != 0u;
    leaf.landing.w = bitcast<f32>(slots[2u * slot + 1u].x);
    if !lies && (!in_the_air(leaf) || window.recolor) {
        fill(slot, leaf);
        lies = !in_the_air(leaf);
    }
    if lies {
        slots[2u * slot + 1u].z = packed_colors(leaf).x;
        var out = lying_leaf(bitcast<vec4<f32>>(slots[2u * slot]), slots[2u * slot + 1u]);
        out.scale *= vanishing(vanish_time(stream, entry));
        return located(out, LIES);
    }
    let elapsed = since(leaf.falls.detach_time);
    let settles = elapsed > leaf.landing.w - settle_time(leaf.landing.w);
    let a = bitcast<vec4<f32>>(slots[2u * slot]);
    let b = slots[2u * slot + 1u];
    let variant = variant_of(b.y, a.xyz);
    let flight = flight_of(variant.flight);
    if !settles && fall.paper_variation == 0u && !near_twig(flight, variant, elapsed) {
        return located(flying_leaf(a, b, flight, variant, window.gusts), FLIES); // it has only another colour
    }
    if settles {
        lie_down(&leaf);
    }
    return located(loose_leaf(leaf), place_in_air(elapsed));
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
    var color = unpack4x8unorm(b.z).rgb * sqrt(withering(since(a.w)));
    if fall.color_loops == 1u {
        color = sqrt(LANDED_COLOR * 0.5);
    }
    return LooseLeaf(a.xyz, slot_size(b), b.x, b.y, shaded(color), b.w | 0xff000000u);
}

// A leaf on its path, neither near its twig nor near the ground.
fn flying_leaf(a: vec4<f32>, b: vec4<u32>, flight: Flight, variant: Variant, gusts: vec4<f32>) -> LooseLeaf {
    let elapsed = since(a.w);
    let free = way(flight, variant, elapsed);
    let blown = wind_since(elapsed, gusts);
    var color = b.z;
    if fall.color_loops == 1u {
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


// How many entries the leaf in local slot `at` is behind the last that detached.
fn entries_back(window: Window, at: u32) -> u32 {
    return window.newest - at + select(0u, window.keep, at > window.newest);
}

// Poses the leaf in local slot `at` of a stream if it flies or lies. If it changes, it is listed for `transition`.
// Returns 1 for a leaf in the air, 0x400 for one on the ground, 0x100000 more for one that was posed for good.
fn pose_slot(window: Window, group: u32, at: u32) -> u32 {
    let back = entries_back(window, at);
    let held = at < window.keep && back < window.detached;
    let slot = window.slot_first + select(0u, at, held);
    let a = bitcast<vec4<f32>>(slots[2u * slot]);
    let b = slots[2u * slot + 1u];
    let there = slot_size(b) > 0.0;
    let lies = (b.x & SIGN) != 0u;
    let elapsed = since(a.w);
    let landing = bitcast<f32>(b.x);
    let vanishes = window.detached - 1u - back + window.keep < window.soon;
    var changes = held && there && (window.recolor || vanishes || (!lies && elapsed > landing - settle_time(landing)));
    let in_air = held && !lies && elapsed < landing;
    let settled = lies && a.w <= SETTLED;
    var leaf: LooseLeaf;
    if lies {
        leaf = located(lying_leaf(a, b), LIES);
    } else {
        let variant = variant_of(b.y, a.xyz);
        let flight = flight_of(variant.flight);
        // The paper's variation follows from the leaf's place on the twig, which slots do not hold.
        let slow = fall.paper_variation != 0u || near_twig(flight, variant, elapsed);
        changes = changes || (held && slow);
        leaf = located(flying_leaf(a, b, flight, variant, window.gusts), place_in_air(elapsed));
    }
    if changes {
        let i = atomicAdd(&counters[CHANGES], 1u);
        work[listed_at(i)][i % 4u] = group * GROUP + at % GROUP;
        if i % BLOCK == 0u && i < BLOCK * ROW {
            atomicAdd(&counters[CHANGE_GROUPS], 1u);
        }
    } else if held && there && !settled {
        posed[slot] = leaf;
        if lies && elapsed > WITHERING {
            slots[2u * slot].w = bitcast<u32>(SETTLED);
        }
    }
    let lying = select(0x400u, 0x100400u, settled && !changes);
    return select(0u, select(lying, 1u, in_air), held && there);
}

// Groups of slots of a workgroup that are awake, and what is counted of each.
var<workgroup> awake: array<u32, MOST_TOGETHER>;
var<workgroup> awake_count: atomic<u32>;
var<workgroup> counts: array<atomic<u32>, MOST_TOGETHER>;

// Groups of slots that a workgroup poses: of many several, since most of many are at rest, and a workgroup that does
// nothing costs something too.
fn groups_together() -> u32 {
    return clamp(fall.group_count / TOGETHER_FROM, 1u, MOST_TOGETHER);
}

// Poses the leaves that fly and those that lie. Leaves that change are listed for `transition`: few at a time, and
// costlier. A thread has several slots, BLOCK apart: what they have in common is read once.
@compute @workgroup_size(BLOCK)
fn pose(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    // None of a group at rest, which `wake` has counted.
    let own = (id.y * ROW + id.x) * groups_together() + local;
    if local < groups_together() && own < fall.group_count && work[rest_at(own) + 1u].y == 0u {
        awake[atomicAdd(&awake_count, 1u)] = own;
    }
    workgroupBarrier();
    // Software drivers run both sides of a branch, but leave a loop.
    let count = atomicLoad(&awake_count);
    for (var k = 0u; k < count; k++) {
        let window = window_of(lists[2u * awake[k]]);
        let first = lists[2u * awake[k] + 1u];
        var posed_here = 0u;
        for (var i = 0u; i < GROUP; i += BLOCK) {
            posed_here += pose_slot(window, awake[k], first + i + local);
        }
        atomicAdd(&counts[k], posed_here);
    }
    workgroupBarrier();
    if local < count {
        let group = awake[local];
        let all = atomicLoad(&counts[local]);
        let lying = (all >> 10u) & 0x3ffu;
        atomicAdd(&counters[IN_AIR], all & 0x3ffu);
        atomicAdd(&counters[ON_GROUND], lying);
        if lying > 0u && (all & 0x3ffu) == 0u && all >> 20u == lying {
            add_calm(group);
        }
    }
}

var<workgroup> lows: array<vec3<f32>, BLOCK>;
var<workgroup> highs: array<vec4<f32>, BLOCK>;
var<workgroup> lying_count: atomic<u32>;

// Notes what a view has to know of a group that has come to rest, and until when it rests.
@compute @workgroup_size(BLOCK)
fn settle(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    // None in the last row's end.
    let i = id.y * ROW + id.x;
    let there = i < atomicLoad(&counters[CALM]);
    let at_list = select(0u, i, there);
    let group = select(0u, work[calm_at(at_list)][at_list % 4u], there);
    let window = window_of(lists[2u * group]);
    let first = lists[2u * group + 1u];
    var low = vec3(1e30);
    var high = vec4(vec3(-1e30), 0.0);
    for (var i = 0u; i < GROUP; i += BLOCK) {
        let at = first + i + local;
        let held = at < window.keep && entries_back(window, at) < window.detached;
        let leaf = posed[window.slot_first + select(0u, at, held)];
        if held && leaf.scale > 0.0 {
            low = min(low, leaf.position);
            high = max(high, vec4(leaf.position, leaf.scale));
            atomicAdd(&lying_count, 1u);
        }
    }
    lows[local] = low;
    highs[local] = high;
    workgroupBarrier();
    for (var step = BLOCK / 2u; step > 0u; step /= 2u) {
        if local < step {
            lows[local] = min(lows[local], lows[local + step]);
            highs[local] = max(highs[local], highs[local + step]);
        }
        workgroupBarrier();
    }
    if local > 0u || !there {
        return;
    }
    let most = highs[0];
    // The first entry to come that has its slot here.
    let next = window.detached % window.keep;
    var until = window.detached;
    if next < first {
        until += first - next;
    } else if next - first >= GROUP {
        until += window.keep - next + first;
    }
    let at = rest_at(group);
    work[at] = bitcast<vec4<u32>>(vec4(0.5 * (lows[0] + most.xyz), 0.5 * distance(lows[0], most.xyz)));
    work[at + 1u] = vec4(until, atomicLoad(&lying_count), bitcast<u32>(most.w), 0u);
}

// Poses the listed leaves: those that leave their twigs, settle, have just landed, or vanish.
@compute @workgroup_size(BLOCK)
fn transition(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = atomicLoad(&counters[CHANGES]);
    for (var i = id.x; i < count; i += BLOCK * ROW) {
        let leaf_at = listed(i);
        let window = window_of(leaf_at.stream);
        let slot = window.slot_first + leaf_at.at;
        let entry = window.detached - 1u - entries_back(window, leaf_at.at);
        posed[slot] = changing_leaf(leaf_at.stream, slot, entry, window);
    }
}
