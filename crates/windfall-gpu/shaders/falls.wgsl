// Leaves that have left their twigs, in the air and on the ground: landing, pose, compaction.

@group(1) @binding(0) var<uniform> fall: FallFrame;
@group(1) @binding(1) var<storage, read> tables: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read> streams: array<Stream>;
// For each 64 slots the stream of the first; from fall.slot_count / 64 on the shed lists.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var<storage, read> leaves: array<LeafRecord>;
@group(1) @binding(5) var<storage, read> models: array<Model>;
// Two vectors a slot: where and when the leaf lands; how it lies, and the entry (plus one) it is of.
// Then a vector a stream, of which x counts the leaves that have detached.
@group(1) @binding(6) var<storage, read_write> slots: array<vec4<u32>>;
@group(1) @binding(7) var<storage, read_write> drawn: array<LooseLeaf>;
// Five words a draw: its indirect arguments. Then the tallies: leaves in the air, of those drawn,
// leaves on the ground, of those drawn, leaves drawn on twigs; then how many slots `land` has to
// fill: in workgroups, 1, and in slots.
@group(1) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;

fn table(i: u32) -> vec4<f32> {
    return tables[i];
}

fn list_entry(stream: Stream, j: u32) -> u32 {
    return lists[(fall.slot_count + 63u) / 64u + stream.list_first + j];
}

fn detach_of(stream: Stream, rank: u32) -> f32 {
    return detach_time(stream.seed, stream.delay, stream.gust_phase, stream.leaf_count, rank);
}

// Counts the leaves of each stream that have detached.
@compute @workgroup_size(64)
fn windows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= fall.stream_count {
        return;
    }
    let stream = streams[id.x];
    let detached = detached_by_now(stream.seed, stream.delay, stream.gust_phase, stream.leaf_count);
    var low = 0u;
    var high = stream.list_count;
    while low < high {
        let middle = (low + high) / 2u;
        if leaves[stream.leaf_first + list_entry(stream, middle)].rank < detached {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    slots[2u * fall.slot_count + id.x] = vec4(low, 0u, 0u, 0u);
}

// The leaf that a slot holds now.
struct Held {
    held: bool,
    stream: u32,
    entry: u32,
}

fn held_by(slot: u32, first_slot: u32) -> Held {
    var out = Held(false, 0u, 0u);
    if slot >= fall.slot_count {
        return out;
    }
    var s = lists[first_slot / 64u];
    while s < fall.stream_count && slot >= streams[s].slot_first + streams[s].keep {
        s += 1u;
    }
    if s >= fall.stream_count || slot < streams[s].slot_first {
        return out;
    }
    let detached = slots[2u * fall.slot_count + s].x;
    let keep = streams[s].keep;
    let local = slot - streams[s].slot_first;
    if detached == 0u {
        return out;
    }
    let newest = detached - 1u;
    let back = (newest % keep + keep - local) % keep;
    out.held = back <= newest;
    out.stream = s;
    out.entry = newest - back;
    return out;
}

fn leaf_fall(stream: Stream, leaf: u32, record: LeafRecord) -> LeafFall {
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
    out.seed = hash(stream.seed, leaf);
    out.path_group = stream.path_group;
    out.detach_time = detach_of(stream, record.rank);
    return out;
}

// Lists the slots whose leaf has changed: those that detached since the slots were last looked at,
// or all of them after a seek. The list is kept in `drawn`, which nothing else uses yet.
@compute @workgroup_size(64)
fn find(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let held = held_by(id.x, group.x * 64u);
    if held.held && slots[2u * id.x + 1u].z != held.entry + 1u {
        let i = atomicAdd(&counters[5u * fall.bin_count + 7u], 1u);
        drawn[i].look = id.x;
        if i % 64u == 0u {
            atomicAdd(&counters[5u * fall.bin_count + 5u], 1u);
        }
    }
}

// Finds where the leaves of the listed slots will land.
@compute @workgroup_size(64)
fn land(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&counters[5u * fall.bin_count + 7u]) {
        return;
    }
    let slot = drawn[id.x].look;
    let held = held_by(slot, slot);
    let stream = streams[held.stream];
    let leaf = list_entry(stream, held.entry);
    let falls = leaf_fall(stream, leaf, leaves[stream.leaf_first + leaf]);
    let landing = landing_of(falls, variant_of(falls));
    slots[2u * slot] = bitcast<vec4<u32>>(vec4(landing.position, landing.time));
    slots[2u * slot + 1u] = vec4(
        pack2x16snorm(landing.orientation.xy),
        pack2x16snorm(landing.orientation.zw),
        held.entry + 1u,
        0u,
    );
}

fn in_view(position: vec3<f32>, radius: f32) -> bool {
    if distance(position, frame.eye) < fall.shadow_reach {
        return true;
    }
    for (var i = 0u; i < 5u; i++) {
        if dot(fall.frustum[i], vec4(position, 1.0)) < -radius {
            return false;
        }
    }
    return true;
}

var<workgroup> workgroup_count: atomic<u32>;
var<workgroup> workgroup_first: u32;
var<workgroup> workgroup_tally: array<atomic<u32>, 4>;

// What is constant for the leaf of an entry that `slot` holds.
fn leaf_constants(stream: Stream, entry: u32, slot: u32) -> LeafConstants {
    let leaf = list_entry(stream, entry);
    let record = leaves[stream.leaf_first + leaf];
    let how = slots[2u * slot + 1u];
    var out: LeafConstants;
    out.falls = leaf_fall(stream, leaf, record);
    out.landing = bitcast<vec4<f32>>(slots[2u * slot]);
    out.lying = normalize(vec4(unpack2x16snorm(how.x), unpack2x16snorm(how.y)));
    out.scale = record.scale * stream.scale;
    out.stack = stack_height(out.scale, stream.thickness, out.falls.seed);
    out.vanish_time = 1e30;
    let next = entry + stream.keep;
    if next < stream.list_count && fall.time - out.falls.detach_time >= out.landing.w {
        let rank = leaves[stream.leaf_first + list_entry(stream, next)].rank;
        out.vanish_time = detach_of(stream, rank);
    }
    let from_center = (record.center - models[stream.model].crown_center) / models[stream.model].crown_extent;
    out.ripe = ripeness(stream.season_offset, from_center.y);
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
    return out;
}

// Poses the leaves and gathers those in view for drawing.
@compute @workgroup_size(64)
fn pose(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let held = held_by(id.x, group.x * 64u);
    var out: LooseLeaf;
    var seen = false;
    var in_air = false;
    var bin = 0u;
    var bin_first = 0u;
    if held.held {
        let stream = streams[held.stream];
        bin = stream.bin;
        bin_first = stream.bin_first;
        let constants = leaf_constants(stream, held.entry, id.x);
        out = loose_leaf(constants);
        in_air = fall.time - constants.falls.detach_time < constants.landing.w;
        seen = in_view(out.position, stream.radius * out.scale);
    }
    if local == 0u {
        atomicStore(&workgroup_count, 0u);
        for (var i = 0u; i < 4u; i++) {
            atomicStore(&workgroup_tally[i], 0u);
        }
    }
    workgroupBarrier();
    if held.held {
        atomicAdd(&workgroup_tally[select(2u, 0u, in_air)], 1u);
    }
    var place = 0u;
    if seen {
        place = atomicAdd(&workgroup_count, 1u);
        atomicAdd(&workgroup_tally[select(3u, 1u, in_air)], 1u);
        // All leaves of a workgroup are of one draw: whoever is first asks for all of them.
        if place == 0u {
            workgroup_first = bin;
        }
    }
    workgroupBarrier();
    if local < 4u {
        let tally = atomicLoad(&workgroup_tally[local]);
        if tally > 0u {
            atomicAdd(&counters[5u * fall.bin_count + local], tally);
        }
    }
    let count = atomicLoad(&workgroup_count);
    if local == 0u && count > 0u {
        workgroup_first = atomicAdd(&counters[5u * workgroup_first + 1u], count);
    }
    workgroupBarrier();
    if seen {
        drawn[bin_first + workgroup_first + place] = out;
    }
}
