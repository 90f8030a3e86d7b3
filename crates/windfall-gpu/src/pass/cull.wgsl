// Which trees are drawn, in which detail: lists in which the more detailed trees of a model come
// first, so that each part of its leaves is drawn for a prefix of them, and each level of its wood for
// a range. Of each kind there is a list for each view; a tree is in the list of every form that some of its leaves
// may have. A stable counting sort: the order of a list, and so the picture, does not depend on the order in which
// threads run.

@group(1) @binding(0) var<uniform> cull: CullFrame;
@group(1) @binding(1) var<uniform> fall: FallFrame;
@group(1) @binding(2) var<storage, read> trees: array<TreeRecord>;
@group(1) @binding(3) var<storage, read> models: array<Model>;
// For each draw: lowest bucket of its trees in the lower byte, highest in the next, kind in the third; unused;
// indices; first index.
@group(1) @binding(4) var<storage, read> draws: array<vec4<u32>>;
// For each list and place: the tree's bucket in the lower 8 bits (0: not drawn), whether the pyramid
// hides it, and its rank among those of its bucket in its block.
@group(1) @binding(5) var<storage, read_write> keys: array<u32>;
// For each list, block and bucket the number of trees; after `prefix_sum` of those in blocks before.
// Behind them, for each list, model and bucket where the bucket begins.
@group(1) @binding(6) var<storage, read_write> counts: array<u32>;
// Five words a draw: indirect arguments. Then the tallies of the view, two words each: trees, their
// leaves, leaves by lambda, leaves on twigs, triangles, trees that others hide
// and their leaves by lambda.
@group(1) @binding(7) var<storage, read_write> arguments: array<atomic<u32>>;
@group(1) @binding(8) var<storage, read_write> placed: array<TreeInstance>;
// Farthest depth of twice two pixels, then level by level; and the clip space that it is of.
@group(2) @binding(0) var pyramid: texture_2d<f32>;
@group(2) @binding(1) var<uniform> seen_from_world: mat4x4<f32>;

const NO_TREE: u32 = 0xffffffffu;
const HIDDEN: u32 = 0x100u;

fn block_total() -> u32 {
    return cull.tree_count / BLOCK;
}

fn bucket_starts() -> u32 {
    return LISTS * block_total() * BUCKETS;
}

fn tally(which: u32, amount: u32) {
    let at = LISTS * DRAW_WORDS * cull.draw_count + 2u * which;
    let before = atomicAdd(&arguments[at], amount);
    if before + amount < before {
        atomicAdd(&arguments[at + 1u], 1u);
    }
}

fn center_of(tree: TreeRecord, crown: Crown) -> vec3<f32> {
    let c = crown.center;
    let turned = vec3(tree.cos_yaw * c.x + tree.sin_yaw * c.z, c.y, tree.cos_yaw * c.z - tree.sin_yaw * c.x);
    return tree.position + turned * tree.scale;
}

// How far a part of a tree is moved by the wind at most, metres: as windfall_core::sway::farthest.
fn farthest_sway(speed: f32, high: f32) -> f32 {
    return min(speed * speed * 1.5e-4 * high * sqrt(high), 0.03 * high) + 0.03 * min(speed, 8.0);
}

// How far leaves of a tree may be beyond its bounds, metres: as they have grown, and by the wind.
fn margin_of(list: TreeList, crown: Crown, scale: f32, center: vec3<f32>) -> f32 {
    let growth = tree_level(list, crown, scale, center).growth;
    let sway = farthest_sway(cull.wind_speed, 2.0 * crown.radius * scale);
    return (growth - 1.0) * crown.leaf_length * scale + sway;
}

fn sphere_in(list: TreeList, center: vec3<f32>, radius: f32) -> bool {
    for (var i = 0u; i < 5u; i++) {
        if dot(list.planes[i], vec4(center, 1.0)) < -radius {
            return false;
        }
    }
    return true;
}

// All corners of the bounding box on the outer side of one clip plane (SFS, 4.2).
fn box_in(list: TreeList, tree: TreeRecord, crown: Crown, margin: f32) -> bool {
    let half_size = crown.half_size + margin / tree.scale;
    var outside = array<u32, 5>(0u, 0u, 0u, 0u, 0u);
    for (var corner = 0u; corner < 8u; corner++) {
        let side = vec3(f32(corner & 1u), f32((corner >> 1u) & 1u), f32(corner >> 2u)) * 2.0 - 1.0;
        let c = crown.center + side * half_size;
        let turned = vec3(tree.cos_yaw * c.x + tree.sin_yaw * c.z, c.y, tree.cos_yaw * c.z - tree.sin_yaw * c.x);
        let at = list.clip_from_world * vec4(tree.position + turned * tree.scale, 1.0);
        outside[0] += u32(at.x < -at.w);
        outside[1] += u32(at.x > at.w);
        outside[2] += u32(at.y < -at.w);
        outside[3] += u32(at.y > at.w);
        outside[4] += u32(at.z > at.w);
    }
    for (var plane = 0u; plane < 5u; plane++) {
        if outside[plane] == 8u {
            return false;
        }
    }
    return true;
}

// Whether a sphere lies behind everything that a pyramid of depth holds; never wrong when it says so.
// The bounds of a sphere in perspective: Mara & McGuire, "2D Polyhedral Bounds of a Clipped,
// Perspective-Projected 3D Sphere", JCGT 2(2), 2013.
fn hidden(clip_from_world: mat4x4<f32>, center: vec3<f32>, radius: f32) -> bool {
    // Rows of x, y and w: scaled axes of the camera.
    let m = transpose(clip_from_world);
    let at = vec3(dot(m[0], vec4(center, 1.0)), dot(m[1], vec4(center, 1.0)), dot(m[3], vec4(center, 1.0)));
    let near_side = at.z - radius;
    if near_side <= cull.near {
        return false;
    }
    // In units in which the edge of the picture is at 1 and w is the distance.
    let stretch = vec2(length(m[0].xyz), length(m[1].xyz));
    let low = vec2(bound(at.x / stretch.x, at.z, radius, -1.0), bound(at.y / stretch.y, at.z, radius, -1.0)) * stretch;
    let high = vec2(bound(at.x / stretch.x, at.z, radius, 1.0), bound(at.y / stretch.y, at.z, radius, 1.0)) * stretch;
    let size = vec2(cull.width, cull.height);
    // Rows of pixels go down.
    let first = clamp(vec2(0.5 + 0.5 * low.x, 0.5 - 0.5 * high.y) * size - 1.0, vec2(0.0), size - 1.0);
    let last = clamp(vec2(0.5 + 0.5 * high.x, 0.5 - 0.5 * low.y) * size + 1.0, vec2(0.0), size - 1.0);
    let extent = max(last.x - first.x, last.y - first.y);
    // A texel of level n is 2^(n+1) pixels wide.
    let level = min(u32(max(ceil(log2(max(extent, 1.0))), 1.0)) - 1u, cull.top_level);
    let a = vec2<u32>(first) >> vec2(level + 1u);
    let b = vec2<u32>(last) >> vec2(level + 1u);
    var farthest = 1.0;
    for (var y = a.y; y <= b.y; y++) {
        for (var x = a.x; x <= b.x; x++) {
            farthest = min(farthest, textureLoad(pyramid, vec2(x, y), i32(level)).r);
        }
    }
    return cull.near / near_side < farthest;
}

// One side of a circle about (x, z), seen from the origin, on the line z = 1.
fn bound(x: f32, z: f32, radius: f32, side: f32) -> f32 {
    let tangent = sqrt(max(x * x + z * z - radius * radius, 0.0));
    return (x * tangent + side * z * radius) / max(z * tangent - side * x * radius, 1e-9);
}

// The list that a row of workgroups makes: a kind after the other, of each view.
fn list_of(row: u32, rows: u32) -> u32 {
    let views = rows / KINDS;
    return row / views * VIEWS + row % views;
}

// How far wood may be from its place, metres of the tree.
fn wood_error(list: TreeList, scale: f32, center: vec3<f32>) -> f32 {
    return list.wood_pixels * distance(center, list.eye) / (list.pixels * scale);
}

// The finest level of wood is the highest bucket.
fn wood_bucket(list: TreeList, crown: Crown, scale: f32, center: vec3<f32>) -> u32 {
    let error = wood_error(list, scale, center);
    var level = 1u;
    while level < crown.wood_levels && crown.wood_errors[level / 4u][level % 4u] <= error {
        level += 1u;
    }
    return BUCKETS + 1u - level;
}

// A tree's bucket in a list, 0 if it is not in it.
fn key_of(list_index: u32, list: TreeList, crown: Crown, scale: f32, center: vec3<f32>) -> u32 {
    let kind = list_index / VIEWS;
    if kind == WOOD {
        return wood_bucket(list, crown, scale, center);
    }
    let level = tree_level(list, crown, scale, center);
    let range = leaf_range(list, crown, level, scale, center);
    let lit = lit_leaf_pixels(list);
    var some = range.x < list.leaf_pixels;
    if kind == PIXELS {
        some = range.y >= lit;
    } else if kind == OUTLINES {
        some = range.y >= list.leaf_pixels && range.x < lit;
    }
    return select(0u, bucket_of(fade_end(list, level)), some);
}

fn bucket_of(drawn: f32) -> u32 {
    return u32(clamp(f32(BUCKETS) + ceil(OCTAVE * log2(max(drawn, 1e-9))), 1.0, f32(BUCKETS)));
}

var<workgroup> block_keys: array<u32, BLOCK>;
var<workgroup> block_counts: array<u32, BUCKETS>;

fn count_block(list: u32, block: u32, local: u32, key: u32) {
    block_keys[local] = key;
    if local < BUCKETS {
        block_counts[local] = 0u;
    }
    workgroupBarrier();
    let bucket = key & 0xffu;
    if bucket > 0u {
        var rank = 0u;
        var last = true;
        for (var i = 0u; i < BLOCK; i++) {
            let same = (block_keys[i] & 0xffu) == bucket;
            rank += u32(same && i < local);
            last = last && !(same && i > local);
        }
        if last {
            block_counts[bucket - 1u] = rank + 1u;
        }
        keys[list * cull.tree_count + block * BLOCK + local] = key | (rank << 16u);
    } else {
        keys[list * cull.tree_count + block * BLOCK + local] = key;
    }
    workgroupBarrier();
    if local < BUCKETS {
        counts[(list * block_total() + block) * BUCKETS + local] = block_counts[local];
    }
}

// Finds each tree's bucket in each list.
@compute @workgroup_size(BLOCK)
fn classify(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) rows: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let list_index = list_of(group.y, rows.y);
    let place = group.x * BLOCK + local;
    let tree = trees[place];
    var key = 0u;
    if tree.model != NO_TREE {
        let list = cull.lists[list_index % VIEWS];
        let crown = models[tree.model].crown;
        let center = center_of(tree, crown);
        let margin = margin_of(list, crown, tree.scale, center);
        let radius = crown.radius * tree.scale + margin;
        var seen = list.culling == 0u;
        if list.culling == 1u {
            seen = box_in(list, tree, crown, margin);
        } else if list.culling > 1u {
            seen = sphere_in(list, center, radius);
        }
        if seen {
            key = key_of(list_index, list, crown, tree.scale, center);
            if list.culling == 3u && hidden(seen_from_world, center, radius) {
                key = HIDDEN;
            }
        }
    }
    count_block(list_index, group.x, local, key);
}

// Of the view's trees that were hidden in the frame before: those that are not hidden now.
@compute @workgroup_size(BLOCK)
fn reclassify(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) rows: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let list_index = list_of(group.y, rows.y);
    let place = group.x * BLOCK + local;
    var key = 0u;
    if keys[list_index * cull.tree_count + place] == HIDDEN {
        let tree = trees[place];
        let list = cull.lists[0];
        let crown = models[tree.model].crown;
        let center = center_of(tree, crown);
        let radius = crown.radius * tree.scale + margin_of(list, crown, tree.scale, center);
        if !hidden(list.clip_from_world, center, radius) {
            key = key_of(list_index, list, crown, tree.scale, center);
        } else if list_index == WOOD * VIEWS {
            tally(5u, 1u);
            let level = tree_level(list, crown, tree.scale, center);
            tally(6u, u32(level.lambda * f32(crown.leaf_count) + 0.5));
        }
    }
    count_block(list_index, group.x, local, key);
}

var<workgroup> totals: array<u32, BUCKETS>;
// Trees of each bucket and above it.
var<workgroup> from_bucket: array<u32, BUCKETS + 2u>;

// For each model and list: where buckets begin, and the arguments of the draws.
@compute @workgroup_size(BLOCK)
fn prefix_sum(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) rows: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let model = group.x;
    let list = list_of(group.y, rows.y);
    let crown = models[model].crown;
    let first = (list * block_total() + crown.tree_first / BLOCK) * BUCKETS;
    if local < BUCKETS {
        var sum = 0u;
        for (var block = 0u; block < crown.block_count; block++) {
            let at = first + block * BUCKETS + local;
            let here = counts[at];
            counts[at] = sum;
            sum += here;
        }
        totals[local] = sum;
    }
    workgroupBarrier();
    if local == 0u {
        from_bucket[BUCKETS + 1u] = 0u;
        for (var bucket = BUCKETS; bucket > 0u; bucket--) {
            from_bucket[bucket] = from_bucket[bucket + 1u] + totals[bucket - 1u];
        }
    }
    workgroupBarrier();
    if local < BUCKETS {
        counts[bucket_starts() + (list * cull.model_count + model) * BUCKETS + local] = from_bucket[local + 2u];
    }
    var triangles = 0u;
    for (var i = local; i < crown.draw_count; i += BLOCK) {
        let draw = draws[crown.draw_first + i];
        // Outlines are drawn for two kinds.
        let kind = list / VIEWS;
        if draw.x >> 16u != select(kind, OUTLINES, kind == PIXELS) {
            continue;
        }
        let begin = from_bucket[((draw.x >> 8u) & 0xffu) + 1u];
        let end = from_bucket[draw.x & 0xffu];
        let at = DRAW_WORDS * (list * cull.draw_count + crown.draw_first + i);
        atomicStore(&arguments[at], draw.z);
        atomicStore(&arguments[at + 1u], end - begin);
        atomicStore(&arguments[at + 2u], draw.w);
        atomicStore(&arguments[at + 3u], 0u);
        atomicStore(&arguments[at + 4u], begin);
        triangles += draw.z / 3u * (end - begin);
    }
    if list % VIEWS == 0u && triangles > 0u {
        tally(4u, triangles);
    }
}

// A direction of the world in a tree.
fn turned_back(tree: TreeRecord, v: vec3<f32>) -> vec3<f32> {
    return vec3(tree.cos_yaw * v.x - tree.sin_yaw * v.z, v.y, tree.cos_yaw * v.z + tree.sin_yaw * v.x);
}

// Mean of the product of the cosines of two directions with a leaf's normal.
fn normal_square(crown: Crown, a: vec3<f32>, b: vec3<f32>) -> f32 {
    return dot(crown.normal_squares, a * b) + 0.5 * dot(crown.normal_products, a * b.yzx + a.yzx * b);
}

// Of the sun on a tree's leaves, on the viewer's side and from behind: as
// windfall_core::simplify::Shading::mean_cosines.
fn mean_cosines(crown: Crown, tree: TreeRecord, view: vec3<f32>) -> vec2<f32> {
    let light = turned_back(tree, frame.sun_direction);
    let eye = turned_back(tree, view);
    let square = normal_square(crown, light, light);
    let lengths = sqrt(square * normal_square(crown, eye, eye));
    let cosine = clamp(normal_square(crown, light, eye) / max(lengths, 1e-9), -1.0, 1.0);
    let angle = acos(cosine);
    let sine = sqrt(1.0 - cosine * cosine);
    return 4.0 / (3.0 * PI) * pow(clamp(square, 1e-9, 1.0), 0.63092975)
        * vec2(sine + (PI - angle) * cosine, sine - angle * cosine);
}

// Puts each tree in its place.
@compute @workgroup_size(BLOCK)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) rows: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let list_index = list_of(group.y, rows.y);
    let at = group.x * BLOCK + local;
    let key = keys[list_index * cull.tree_count + at];
    let bucket = key & 0xffu;
    if bucket == 0u {
        return;
    }
    let list = cull.lists[list_index % VIEWS];
    let tree = trees[at];
    let crown = models[tree.model].crown;
    let level = tree_level(list, crown, tree.scale, center_of(tree, crown));
    let start = counts[bucket_starts() + (list_index * cull.model_count + tree.model) * BUCKETS + bucket - 1u];
    let before = counts[(list_index * block_total() + group.x) * BUCKETS + bucket - 1u];
    var out: TreeInstance;
    out.position = tree.position;
    out.scale = tree.scale;
    out.cos_yaw = tree.cos_yaw;
    out.sin_yaw = tree.sin_yaw;
    out.season_offset = tree.season_offset;
    out.lambda = level.lambda;
    out.fade_end = fade_end(list, level);
    out.fade_slope = 0.5 / max(level.radius, 1e-9);
    out.growth = level.growth;
    if list_index / VIEWS == WOOD {
        out.growth = wood_error(list, tree.scale, center_of(tree, crown));
    }
    out.contrast = select(level.contrast, f32(tree.index_events >> 1u), frame.show == SHOW_IDS);
    out.seed = tree.seed;
    out.wind = pack2x16float(wind_at(tree.position));
    var cosines = vec2(0.5 * list.mean_cosine);
    if list.mean_cosine < 0.0 {
        cosines = mean_cosines(crown, tree, normalize(list.eye - center_of(tree, crown)));
    }
    out.mean_cosines = pack2x16float(cosines);
    let detached = detached_by(0.0, tree.seed, tree.delay, tree.gust_phase, crown.leaf_count);
    out.detached = detached | ((tree.index_events & 1u) << 24u);
    placed[list_index * cull.tree_count + crown.tree_first + start + before + (key >> 16u)] = out;
    // Every tree in view is in the list of wood.
    if list_index == WOOD * VIEWS {
        tally(0u, 1u);
        tally(1u, crown.leaf_count);
        let leaves = f32(crown.leaf_count);
        tally(2u, u32(level.lambda * leaves + 0.5));
        let hanging = 1.0 - f32(detached) / max(leaves, 1.0);
        tally(3u, u32(min(out.fade_end, 1.0) * leaves * hanging + 0.5));
    }
}
