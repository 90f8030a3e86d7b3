// Which leaves of a list of trees are drawn as quads, and where their quads are: all of a part's, for
// all trees that are drawn with it, one part after the other as long as there is room.

// Draws of the list, kernels that spread, room for quads, draws of quads. Then for each draw of the list the leaves of
// its part (0: never in quads), its first corner, the first place of its model's trees. Then for each
// kernel the first of its draws, and how many.
@group(0) @binding(0) var<storage, read> facts: array<vec4<u32>>;
// The list's indirect arguments: those of parts that are drawn as quads are emptied.
@group(0) @binding(1) var<storage, read_write> draws: array<u32>;
// For each draw: first quad, leaves, first corner, place of the first tree; then the number of quads.
@group(0) @binding(2) var<storage, read_write> parts: array<vec4<u32>>;
// Five words for each draw of quads, then three for each kernel: its workgroups.
@group(0) @binding(3) var<storage, read_write> arguments: array<u32>;

var<workgroup> sums: array<u32, BLOCK>;
var<workgroup> accepted: atomic<u32>;

@compute @workgroup_size(BLOCK)
fn arrange(@builtin(local_invocation_index) local: u32) {
    let head = facts[0];
    let room = head.z;
    var before = 0u;
    for (var first = 0u; first < head.x; first += BLOCK) {
        let i = first + local;
        var size = 0u;
        if i < head.x {
            let fact = facts[1u + i];
            let trees = draws[DRAW_WORDS * i + 1u];
            // No sum overflows where every term stops above the room.
            size = fact.x * trees;
            if trees > 0u && fact.x > room / trees {
                size = room + 1u;
            }
        }
        sums[local] = size;
        workgroupBarrier();
        for (var step = 1u; step < BLOCK; step *= 2u) {
            let more = select(0u, sums[max(local, step) - step], local >= step);
            workgroupBarrier();
            sums[local] += more;
            workgroupBarrier();
        }
        let end = before + sums[local];
        if i < head.x {
            let fact = facts[1u + i];
            parts[i] = vec4(end - size, fact.x, fact.y, fact.z + draws[DRAW_WORDS * i + 4u]);
            if size > 0u && end <= room {
                atomicMax(&accepted, end);
                draws[DRAW_WORDS * i + 1u] = 0u;
            }
        }
        before = min(before + sums[BLOCK - 1u], room + 1u);
        workgroupBarrier();
    }
    storageBarrier();
    workgroupBarrier();
    let quads = atomicLoad(&accepted);
    // Parts without room are empty here, and drawn as they were.
    for (var i = local; i < head.x; i += BLOCK) {
        parts[i].x = min(parts[i].x, quads);
    }
    if local == 0u {
        parts[head.x] = vec4(quads, 0u, 0u, 0u);
    }
    for (var i = local; i < head.w; i += BLOCK) {
        let first = i * BATCH;
        let count = min(quads - min(first, quads), BATCH);
        arguments[DRAW_WORDS * i] = 6u * count;
        arguments[DRAW_WORDS * i + 1u] = min(count, 1u);
        arguments[DRAW_WORDS * i + 2u] = 0u;
        arguments[DRAW_WORDS * i + 3u] = 4u * first;
        arguments[DRAW_WORDS * i + 4u] = 0u;
    }
    storageBarrier();
    workgroupBarrier();
    for (var i = local; i < head.y; i += BLOCK) {
        let kernel = facts[1u + head.x + i];
        let count = parts[kernel.x + kernel.y].x - parts[kernel.x].x;
        let at = DRAW_WORDS * head.w + 3u * i;
        arguments[at] = (count + BLOCK - 1u) / BLOCK;
        arguments[at + 1u] = 1u;
        arguments[at + 2u] = 1u;
    }
}
