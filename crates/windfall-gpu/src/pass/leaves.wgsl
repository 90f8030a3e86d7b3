// Leaves on their twigs.

@group(1) @binding(0) var<uniform> model: Model;
@group(1) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(1) @binding(2) var pictures: texture_2d_array<f32>;
@group(1) @binding(3) var picture_sampler: sampler;
struct LeafVertex {
    @location(0) center: vec3<f32>,
    @location(1) leaf: u32,
    @location(2) offset_ambient: vec4<f32>,
    @location(3) normal: vec4<f32>,
    // Octahedral, as where it hangs no longer.
    @location(4) bent_normal: vec4<f32>,
    @location(5) uv: vec2<f32>,
    @location(6) material_shed: u32,
}

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // What reaches the leaf of the sun, of one far away, in `w`. Of leaves on twigs that are lit
    // once, their radiance. Within the leaf: of one that covers no pixel's middle, that of its plane there may be many
    // times what any of its corners has.
    @location(2) @interpolate(perspective, centroid) bent_normal_reach: vec4<f32>,
    @location(3) uv: vec2<f32>,
    // Of small loose leaves their radiance. Where leaves are told apart (SHOW_IDS), leaf and tree.
    @location(4) @interpolate(flat) color: vec3<f32>,
    // Index of its surface in the lowest byte; above it the leaf's bent normal, which tells it from others.
    @location(5) @interpolate(flat) material: u32,
    @location(6) @interpolate(flat) ambient: f32,
    // What is left of the contrast of shading; how much of the leaf is seen, where it fades by opacity;
    // the mean cosines of the sun towards which shading draws together, on the viewer's side and behind.
    @location(7) @interpolate(flat) contrast_seen_cosines: vec4<f32>,
}

// Of outlines that are lit at their vertices: no more than their pixels need.
struct Outline {
    @builtin(position) clip: vec4<f32>,
    // Radiance; the way from the midrib, in widths of the blade, to the right.
    @location(0) radiance_across: vec4<f32>,
    // Where leaves are told apart: Varyings.color.
    @location(1) @interpolate(flat) most_radiance: vec3<f32>,
}

// The form that the pipeline draws: leaves of another form are left out. windfall_core::simplify::LeafForm.
override form: u32 = PIXELS;
// Whether the pass has colours. Shadow maps have none.
override lit: bool = true;
// Whether leaves are lit at their vertices: those without pictures that are not near.
override lit_at_vertices: bool = false;
// Whether each vertex is lit for itself, and the pixels between them have what lies between; if not, a leaf is
// lit once, as those are that are a few pixels wide.
override outlines: bool = false;
// Whether shadows are looked up at vertices, of leaves with pictures that are not near. Settled when the pipeline is
// made, as all of these, since software drivers run both sides of every branch.
override reach_at_vertices: bool = false;

// Behind the camera: nothing of it is drawn.
const NOWHERE = vec4<f32>(0.0, 0.0, -1.0, 1.0);
// Where a leaf's wax reflects as much as that of leaves that lean in every direction alike does in the mean,
// each seen by its projected area: cosine to the viewer.
const MEAN_FACING: f32 = 0.456;
// Length of the mean of bent normals at one place of a crown, whose leaves lean in every direction alike.
const BENT_FLATNESS: f32 = 0.86;
// How much of a leaf is margin.
const MEAN_MARGIN: f32 = 0.25;

// A leaf's surface and bent normal in the world, as LooseLeaf.look has them: what stays the same of a leaf on
// its twig, in the air and on the ground.
fn look_of(surface: u32, bent_normal: vec3<f32>) -> u32 {
    return surface | ((pack4x8snorm(vec4(octahedral(bent_normal), 0.0, 0.0)) & 0xffffu) << 8u);
}

fn surface_of(material: u32) -> Surface {
    return surfaces[material & 0xffu];
}

// How much of a leaf is seen (SFS, equation 6), as in windfall_core::simplify.
fn leaf_seen(tree: Tree, leaf: u32) -> f32 {
    let rank = f32(leaf) / f32(model.leaf_count);
    let seen = clamp((tree.fade_growth.x - rank) * tree.fade_growth.y, 0.0, 1.0);
    return select(seen, seen * seen * (3.0 - 2.0 * seen), frame.fade_smooth == 1u);
}

// Full at 1, halves at each step of the colours red, yellow, green, cyan, blue.
fn detail_color(lambda: f32) -> vec3<f32> {
    let x = clamp(-log2(max(lambda, 1e-6)) / 8.0, 0.0, 1.0) * 4.0;
    return clamp(vec3(2.0 - x, min(x, 4.0 - x), x - 2.0), vec3(0.0), vec3(1.0)) * 0.5;
}

// Colour at a phase of the season; white where the material has its own.
fn color_at(phase: f32) -> vec3<f32> {
    if model.palette_count == 0u {
        return vec3(1.0);
    }
    let x = phase * 7.0;
    let i = min(u32(x), 6u);
    return mix(model.palette[i].rgb, model.palette[i + 1u].rgb, x - f32(i));
}

// Its mean over leaves that have times of their own about a phase.
fn mean_color_at(phase: f32) -> vec3<f32> {
    let spread = model.palette_spread;
    let x = clamp((phase + spread) / (1.0 + 2.0 * spread), 0.0, 1.0) * 7.0;
    let i = min(u32(x), 6u);
    return mix(model.mean_palette[i].rgb, model.mean_palette[i + 1u].rgb, x - f32(i));
}

// Whether a program has thrown the leaf by now. Nothing is read for a tree of which it has thrown none.
fn thrown(tree: Tree, leaf: u32) -> bool {
    if (tree.seed_detached_wind_cosines.y >> 24u) == 0u {
        return false;
    }
    let time = scripted_detach(scripted_key(tree.seed_detached_wind_cosines.x, tree.position_scale.xyz), leaf);
    return (frame.shed_time - time) + frame.shed_time_low >= 0.0;
}

// Whether a leaf is simplified away, or in the air or on the ground.
fn gone(leaf: u32, rank: u32, tree: Tree, seen: f32) -> bool {
    let detached = tree.seed_detached_wind_cosines.y & 0xffffffu;
    return seen <= 0.0 || rank < detached || thrown(tree, leaf);
}

// A leaf on its twig in the wind.
struct Hanging {
    // Its centre.
    at: vec3<f32>,
    // How it has turned about that.
    turned: vec4<f32>,
    // Its form.
    form: u32,
}

// `drawn` is the factor on its length.
fn hanging_leaf(center: vec3<f32>, length: f32, drawn: f32, tree: Tree) -> Hanging {
    let rest = tree.position_scale.xyz + turn(tree, center) * tree.position_scale.w;
    let longest = unpack2x16float(model.crown.leaf_lengths).y * tree.position_scale.w;
    let pixels = length * longest * drawn * frame.pixels / max(distance(rest, frame.eye), 1e-3);
    let swayed = sway_and_flutter(rest, tree.position_scale.y);
    return Hanging(rest + swayed.moved, swayed.turned, leaf_form(pixels));
}

// The form of a leaf that is so long in the picture: windfall_core::simplify::Simplification::leaf_form.
fn leaf_form(pixels: f32) -> u32 {
    return select(select(PIXELS, OUTLINES, pixels < frame.lit_leaf_pixels), SIMPLE, pixels < frame.leaf_pixels);
}

// Where a vertex of it is, with its normal: nothing of its light.
fn hanging_vertex(leaf: Hanging, offset: vec3<f32>, normal: vec3<f32>, tree: Tree) -> Varyings {
    var out: Varyings;
    out.normal = turn_by(leaf.turned, turn(tree, normal));
    out.world = leaf.at + turn_by(leaf.turned, turn(tree, offset) * tree.position_scale.w);
    out.clip = frame.clip_from_world * vec4(out.world, 1.0);
    return out;
}

// How far beyond a corner its shadow is sampled, in ways from the middle to the corner. In a simplified tree fewer
// leaves stand for what shades each of many: each for as much of the crown about it as its corners, spread, reach.
fn shade_spread(tree: Tree) -> f32 {
    return smoothstep(0.0, 0.16, 1.0 - tree.turn_season.w);
}

// What reaches a leaf with a picture of the sun, at one of its vertices.
fn corner_reach(world: vec3<f32>, offset: vec3<f32>, tree: Tree) -> f32 {
    let about = turn(tree, offset) * (tree.position_scale.w * (SHADE_SPREAD - 1.0) * shade_spread(tree));
    return sun_visibility(world + about, vec3(0.0), 64.0 * fract(world.xz), 1u, 1.5);
}

// What reaches a leaf that is lit once: a quarter of its samples, which are those of a leaf in the air while
// its tree is in full.
fn quarter_reach(leaf: Hanging, offset: vec3<f32>, normal: vec3<f32>, corner: u32, tree: Tree) -> f32 {
    let about = turn(tree, offset) * (tree.position_scale.w * SHADE_SPREAD * shade_spread(tree));
    let towards = select(-normal, normal, dot(normal, frame.sun_direction) >= 0.0);
    let some = vec2(corner, corner + 1u);
    return sun_visibility_in(leaf.at + about, towards, vec2(0.0), some, 4u, 1.5);
}

// How much of the sun that reaches a corner it is to have, if a share of all that is kept. Of some corners all and of
// others none is: a part of each would be as much in the mean, but without the lights and shades of the whole crown.
fn sunny(in: LeafVertex, share: f32) -> f32 {
    return chosen(share, unit(hash(hash(in.leaf, bitcast<u32>(in.uv.x)), bitcast<u32>(in.uv.y))));
}

// What all vertices of a leaf have alike, but for the light that reaches it.
fn leaf_alike(vertex: Varyings, in: LeafVertex, tree: Tree, seen: f32) -> Varyings {
    var out = vertex;
    let rank = in.material_shed & 0xffffffu;
    let bent_normal = turn(tree, from_octahedral(in.bent_normal.xy));
    out.material = look_of(in.material_shed >> 24u, bent_normal);
    let shading_contrast = select(1.0, tree.fade_growth.w, (frame.contrasts & 2u) != 0u);
    out.contrast_seen_cosines = vec4(shading_contrast, seen, unpack2x16float(tree.seed_detached_wind_cosines.w));
    if !lit {
        return out;
    }
    let from_center = (in.center - model.crown_center) / model.crown_extent;
    // Leaves of one part of the crown have in common where it bulges to.
    let outward = turn(tree, normalize(in.center - model.crown_center + vec3(0.0, 1e-4, 0.0)));
    out.bent_normal_reach = vec4(mix(outward, bent_normal, shading_contrast), 1.0);
    let tree_seed = tree.seed_detached_wind_cosines.x;
    let ripe = tree.turn_season.z + branch_ripeness(tree_seed, from_center);
    let season = leaf_season(tree_seed, ripe, rank, from_center.y, model.palette_spread);
    out.color = season.brightness * color_at(season.phase);
    // SFS, equation 4, towards the mean of leaves in this part of the crown.
    let contrast = select(1.0, tree.fade_growth.w, (frame.contrasts & 1u) != 0u);
    out.color = mix(mean_color_at(frame.season + ripeness(ripe, from_center.y)), out.color, contrast);
    if frame.show == SHOW_DETAIL {
        out.color = detail_color(tree.turn_season.w);
    }
    if frame.show == SHOW_IDS {
        out.color = vec3(f32(in.leaf), tree.fade_growth.w, 0.0);
    }
    out.ambient = mix(ambient_at(model.ambient, from_center), in.offset_ambient.w, shading_contrast);
    return out;
}

// `drawn` is the factor on the leaf's length by which it fades, `corner` the vertex.
fn hanging(in: LeafVertex, corner: u32, tree: Tree, drawn: f32, seen: f32) -> Varyings {
    var out: Varyings;
    out.clip = NOWHERE;
    if gone(in.leaf, in.material_shed & 0xffffffu, tree, seen) {
        return out;
    }
    let size = tree.fade_growth.z * drawn;
    let leaf = hanging_leaf(in.center, in.bent_normal.z, size, tree);
    if leaf.form != form {
        return out;
    }
    let offset = in.offset_ambient.xyz * size;
    out = leaf_alike(hanging_vertex(leaf, offset, in.normal.xyz, tree), in, tree, seen);
    out.uv = in.uv;
    if !lit {
        return out;
    }
    if lit_at_vertices && !outlines {
        var middle = out;
        middle.world = leaf.at;
        middle.bent_normal_reach.w = quarter_reach(leaf, offset, out.normal, corner & 3u, tree);
        out.bent_normal_reach = vec4(radiance_at_vertex(middle), 1.0);
    } else if reach_at_vertices {
        // Of leaves that are lit once that is as much as it should be.
        let share = measured_factor(model.sunlight, tree.turn_season.w);
        out.bent_normal_reach.w = corner_reach(out.world, offset, tree) * sunny(in, share);
    }
    return out;
}

// Small leaves are lit in their middle, so that they have one colour: interpolated within the samples that are
// seen, as some drivers do, it would be another after each leaf that hides some of them.
fn radiance_at_vertex(in: Varyings) -> vec3<f32> {
    let color = dried(tinted(in.color, surface_of(in.material)), MEAN_MARGIN, in.material);
    return in_the_air(leaf_radiance(in, color, 1.0), in.world);
}

// Leaves fade by size: by the root of what is seen, which is an area.
@vertex
fn vertex(in: LeafVertex, tree: Tree, @builtin(vertex_index) index: u32) -> Varyings {
    let seen = leaf_seen(tree, in.leaf);
    return hanging(in, index, tree, sqrt(seen), seen);
}

// Leaves fade by opacity.
@vertex
fn opaque_vertex(in: LeafVertex, tree: Tree, @builtin(vertex_index) index: u32) -> Varyings {
    return hanging(in, index, tree, 1.0, leaf_seen(tree, in.leaf));
}

// Leaves of middling size, and large ones where quality has no lighting in pixels.
@vertex
fn outline(in: LeafVertex, tree: Tree, @builtin(vertex_index) index: u32) -> Outline {
    let seen = leaf_seen(tree, in.leaf);
    let vertex = hanging(in, index, tree, sqrt(seen), seen);
    let across = vertex.uv.x - 0.5;
    let margin = smoothstep(0.22, 0.5, abs(across));
    let albedo = dried(tinted(vertex.color, surface_of(vertex.material)), margin, vertex.material);
    let radiance = in_the_air(leaf_radiance(vertex, albedo, 0.0), vertex.world);
    let leaf = leaf_diffuse(albedo);
    let most = (leaf.reflected + leaf.passed) * (frame.sun_color / PI + 2.0 * frame.ambient[0].rgb);
    return Outline(vertex.clip, vec4(radiance, across), select(most + radiance, vertex.color, frame.show == SHOW_IDS));
}

// The middles of pixels that a leaf covers in part lie beyond it: of one seen from its edge, what its plane
// has there may be anything, and is kept within what the leaf may have.
@fragment
fn lit_outline(in: Outline) -> @location(0) vec4<f32> {
    if frame.show == SHOW_IDS {
        return id_digits(in.most_radiance);
    }
    var radiance = clamp(in.radiance_across.rgb, vec3(0.0), in.most_radiance);
    if !explains() {
        let across = in.radiance_across.w;
        radiance *= midrib(abs(across), fwidth(across));
    }
    return vec4(radiance, 1.0);
}

// A leaf in the air or on the ground: the shape's vertices, and one LooseLeaf per instance.
struct LooseVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) place_scale: vec4<f32>,
    @location(4) orientation: vec4<f32>,
    @location(5) color_ambient: vec4<f32>,
    @location(6) look: u32,
}

fn turn_by(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

// What a vertex in the air or on the ground has of its leaf: the LooseLeaf's colour and look. A leaf that is
// lit once is lit in its middle.
fn loose_varyings(
    world: vec3<f32>,
    middle: vec3<f32>,
    normal: vec3<f32>,
    uv: vec2<f32>,
    color: vec4<f32>,
    look: u32,
) -> Varyings {
    var out: Varyings;
    out.world = middle;
    out.clip = frame.clip_from_world * vec4(world, 1.0);
    out.normal = normal;
    // The crown's bent normal on the twig; in the air light comes from above.
    let bent = mix(from_octahedral(unpack4x8snorm(look).yz), vec3(0.0, 1.0, 0.0), unpack4x8unorm(look).w);
    out.bent_normal_reach = vec4(bent, 1.0);
    out.uv = uv;
    out.color = color.rgb * color.rgb * 2.0;
    out.material = look & 0xffffffu;
    out.ambient = color.w;
    out.contrast_seen_cosines = vec4(1.0, 1.0, 0.0, 0.0);
    if lit_at_vertices {
        out.color = radiance_at_vertex(out);
    }
    if frame.show == SHOW_IDS {
        // What `gather` has put there.
        out.color = vec3(f32(pack4x8unorm(color)), f32(look >> 8u), 0.0);
    }
    out.world = world;
    return out;
}

fn posed(position: vec3<f32>, normal: vec3<f32>, uv: vec2<f32>, leaf: LooseLeaf) -> Varyings {
    let q = normalize(vec4(unpack2x16snorm(leaf.orientation_xy), unpack2x16snorm(leaf.orientation_zw)));
    let world = leaf.position + turn_by(q, position) * leaf.scale;
    return loose_varyings(world, leaf.position, turn_by(q, normal), uv, unpack4x8unorm(leaf.color), leaf.look);
}

@vertex
fn loose(in: LooseVertex) -> Varyings {
    return loose_vertex(in);
}

fn loose_vertex(in: LooseVertex) -> Varyings {
    let q = normalize(in.orientation);
    let world = in.place_scale.xyz + turn_by(q, in.position.xyz) * in.place_scale.w;
    let normal = turn_by(q, in.normal.xyz);
    return loose_varyings(world, in.place_scale.xyz, normal, in.uv, in.color_ambient, in.look);
}

// Mean cosines of the light on a side and on the other of a surface whose normals lean to all sides of one alike.
// `facing` is that one's cosine, `flatness` the length of their mean, 1 of a plane.
fn both_sides(facing: f32, flatness: f32) -> vec2<f32> {
    // The mean square; of cosines spread evenly over an angle the mean is 0.9 of its root.
    let across = 0.4 * (1.0 - min(flatness * flatness, 1.0)) * (1.0 - facing * facing);
    let along = flatness * facing;
    let sum = sqrt(along * along + across);
    return 0.5 * vec2(sum + along, sum - along);
}

// Cosines of the light on a side of a leaf and on the other. A leaf that is lit once has the mean over its
// blade, whose mean normal is the shorter the more it is curved: where light grazes it, it meets both sides.
fn front_and_back(facing: f32, flatness: f32) -> vec2<f32> {
    if !lit_at_vertices || outlines {
        return max(vec2(facing, -facing), vec2(0.0));
    }
    // Over leaves that lean in every direction alike it is a little more than the half that it has to be.
    let flat = min(flatness * flatness, 1.0);
    return both_sides(facing, flatness) / (1.0 + 0.37 * flat * (1.0 - flat));
}

// Radiance of a leaf towards the eye: both sides reflect, and light from behind shines through.
// `pixel` is the size of a pixel on the leaf, in leaves.
fn leaf_radiance(in: Varyings, albedo: vec3<f32>, pixel: f32) -> vec3<f32> {
    let view = normalize(frame.eye - in.world);
    var normal = normalize(in.normal);
    normal = select(-normal, normal, dot(normal, view) >= 0.0);
    if explains() {
        return explained(normal, view, vec3(0.10, 0.42, 0.06));
    }
    // Opposite normals may cancel: a nudge keeps the sum from being nothing.
    let bent = normalize(in.bent_normal_reach.xyz + vec3(0.0, 1e-3, 0.0));
    let sun = frame.sun_direction;
    // Leaves are thin and many: what shadow maps miss between them, depth in the crown stands for.
    let openness = select(1.0, in.ambient, has(AMBIENT_OCCLUSION));
    var reach = in.bent_normal_reach.w;
    if !reach_at_vertices {
        let towards = select(-normal, normal, dot(normal, sun) >= 0.0);
        // Vertices are not at a pixel, whose noise they would have.
        let at = select(in.clip.xy, vec2(0.0), lit_at_vertices);
        reach = sun_visibility(in.world, towards, at, 4u, 1.5);
    }
    reach *= mix(0.6, 1.0, openness);
    let facing = dot(normal, sun);
    let facings = front_and_back(facing, length(in.normal));
    // Drawn towards their means (SFS, 4.3.2).
    let contrast = in.contrast_seen_cosines.x;
    let front = mix(in.contrast_seen_cosines.z, facings.x, contrast);
    let back = mix(in.contrast_seen_cosines.w, facings.y, contrast);
    var leaf = leaf_diffuse(albedo);
    leaf.passed *= select(0.0, 1.0, has(TRANSMISSION));
    let n_v = mix(MEAN_FACING, max(dot(normal, view), 1e-3), contrast);
    let volume = both_sides(dot(bent, sun), mix(BENT_FLATNESS, 1.0, contrast)).x;
    var scattered = leaf_body(leaf, front, back, volume, 0.3, n_v);
    if has(GLOSS) {
        // Glints smaller than a pixel would sparkle: leaves of a few pixels have mostly what many have in the mean.
        let own = contrast * mix(1.0, 0.3, smoothstep(0.1, 0.4, pixel));
        scattered += mix(mean_gloss(sun, view), leaf_gloss(normal, facing, sun, view), own);
    }
    let direct = frame.sun_color * reach * scattered;
    // The mean over leaves is nearly the light from where the crown opens.
    let around = ambient_two_sided(normalize(mix(normal, bent, mix(0.9, 0.35, contrast))));
    // What other leaves hide is lit by what they send on, time and again (Jimenez et al., "Practical
    // Realtime Strategies for Accurate Indirect Occlusion", 2016): deep in the crown the light is warm.
    let open = openness / (1.0 - 0.7 * (leaf.reflected + leaf.passed) * (1.0 - openness));
    return direct + (leaf.reflected * around.front + leaf.passed * around.back) * open;
}

// The margin dries first, of one leaf more than of another; `margin` is 1 there.
fn dried(color: vec3<f32>, margin: f32, leaf: u32) -> vec3<f32> {
    let dry = margin * (0.5 + 0.5 * unit(hash(leaf, 3u)));
    return color * mix(vec3(1.0), vec3(0.72, 0.54, 0.5), dry);
}

// How much paler the midrib is, as much in the mean however wide it is drawn; `across` is the way from it, `pixel`
// the size of a pixel, in widths of the blade.
fn midrib(across: f32, pixel: f32) -> f32 {
    let rib = 1.0 - smoothstep(0.006, 0.016 + pixel, across);
    return 1.0 + 0.35 * rib * 0.022 / (0.022 + pixel);
}

// Midrib and side veins of a built-in leaf, as wide as they may be seen; x runs across the blade, y
// along it. Veins are paler, the blade between them darkens to its margin.
fn venation(uv: vec2<f32>, color: vec3<f32>, leaf: u32) -> vec3<f32> {
    let pixel = max(fwidth(uv.x), fwidth(uv.y));
    let across = abs(uv.x - 0.5);
    var shade = midrib(across, pixel);
    // The middles of pixels that a small leaf covers in part lie beyond its margin: there, the mean.
    let margin = mix(smoothstep(0.22, 0.5, across), MEAN_MARGIN, smoothstep(0.1, 0.4, pixel));
    if pixel < 0.12 && has(VEINS) {
        // Side veins bend to the tip, left and right of the midrib in turn, and not one as the next.
        let key = hash(leaf, 4u);
        let left = select(0.0, 0.5, uv.x < 0.5);
        let turns = (uv.y - across * (1.15 - 0.9 * across)) * 7.0 + left + unit(hash(key, 6u));
        let strength = 0.4 + 0.6 * unit(hash(key, u32(max(floor(turns), 0.0) + 16.0 * left)));
        let side = abs(fract(turns) - 0.5);
        let vein = strength * (1.0 - smoothstep(0.015, 0.06 + 7.0 * pixel, side)) * (1.0 - smoothstep(0.1, 0.45, across));
        shade += (0.11 * vein - 0.01) * (1.0 - smoothstep(0.02, 0.08, pixel));
        // Blotches: some of the green lasts along the veins, some of the margin has died.
        let spots = fractal_noise2(uv * 5.0 + f32(key % 97u), pixel * 5.0, 51u);
        shade *= 1.0 + 0.5 * spots * (1.0 - smoothstep(0.03, 0.12, pixel));
    }
    return dried(color, margin, leaf) * shade;
}

fn in_the_air(radiance: vec3<f32>, world: vec3<f32>) -> vec3<f32> {
    if explains() {
        return radiance;
    }
    return through_air(radiance, world);
}

fn seen_radiance(in: Varyings, albedo: vec3<f32>) -> vec3<f32> {
    let pixel = max(fwidth(in.uv.x), fwidth(in.uv.y));
    return in_the_air(leaf_radiance(in, albedo, pixel), in.world);
}

// DebugView::Ids, of a leaf and its tree.
fn id_digits(leaf_tree: vec3<f32>) -> vec4<f32> {
    let id = vec2<u32>(leaf_tree.xy) + vec2(1u, 0u);
    return vec4<f32>(vec4(id.x & 2047u, id.x >> 11u, id.y & 2047u, id.y >> 11u));
}

@fragment
fn solid(in: Varyings) -> @location(0) vec4<f32> {
    return solid_color(in);
}

fn solid_color(in: Varyings) -> vec4<f32> {
    if frame.show == SHOW_IDS {
        return id_digits(in.color);
    }
    if lit_at_vertices {
        return in.bent_normal_reach;
    }
    let surface = surface_of(in.material);
    let plain = venation(in.uv, tinted(in.color, surface), in.material);
    let pictured = textured(in, surface).rgb;
    return vec4(seen_radiance(in, select(plain, pictured, surface.layer >= 0)), 1.0);
}

// Small loose leaves: all their corners have the same radiance.
@fragment
fn small(in: Varyings) -> @location(0) vec4<f32> {
    return id_or(vec4(in.color, 1.0), in);
}

fn tinted(color: vec3<f32>, surface: Surface) -> vec3<f32> {
    return select(color, color * surface.base_color, model.palette_count == 0u);
}

// The surface's picture. Sampled for every surface, also one without: neighbouring pixels must agree on it.
fn textured(in: Varyings, surface: Surface) -> vec4<f32> {
    let texel = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0));
    if model.palette_count == 0u {
        return vec4(tinted(in.color, surface) * texel.rgb, texel.a);
    }
    // Keep the picture's light and dark, take the season's colour.
    let light = dot(texel.rgb, vec3(0.2126, 0.7152, 0.0722)) / model.texture_luminance;
    return vec4(in.color * clamp(light, 0.0, 2.0), texel.a);
}

// Whether a texel of a shadow map lies in a hole. Where holes are smaller, of each leaf another share of the texels
// does: with the same ones open in all, leaves behind each other would shade no more than one does.
fn shadow_hole(in: Varyings) -> bool {
    let surface = surface_of(in.material);
    let alpha = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0)).a;
    let noise = fract(interleaved_noise(in.clip.xy) + unit(hash(in.material, 9u)));
    return mask_share(surface, alpha, in.uv).x <= noise;
}

@fragment
fn masked_shadow(in: Varyings) {
    if shadow_hole(in) {
        discard;
    }
}

@fragment
fn masked(in: Varyings) -> Faded {
    let masked = masked_color(in);
    let samples = covered_samples(in, masked.share);
    if samples == 0u {
        discard;
    }
    return Faded(id_or(masked.color, in), samples);
}

fn id_or(color: vec4<f32>, in: Varyings) -> vec4<f32> {
    return select(color, id_digits(in.color), frame.show == SHOW_IDS);
}

// Share of a pixel that a picture with holes covers. An edge is a pixel wide, so that it has as many steps as there
// are samples; where pieces are as small as half a pixel, all is edge. Alpha of each mip level is such that it has
// the right share with an edge of that level: of what lies between two levels, so does the edge.
// Then how the share grows from this pixel to the next, to the right and down.
fn mask_share(surface: Surface, alpha: f32, uv: vec2<f32>) -> vec3<f32> {
    let along = dpdx(uv);
    let down = dpdy(uv);
    let size = vec2<f32>(textureDimensions(pictures));
    let pixel = sqrt(max(dot(along, along), dot(down, down)));
    let texels = pixel * max(size.x, size.y);
    let level = clamp(log2(max(texels, 1e-6)), -8.0, f32(textureNumLevels(pictures)) - 1.0);
    let least = 0.5 * exp2(floor(level)) / (max(size.x, size.y) * max(surface.piece, 1e-3));
    let edge = mix(clamp(least, 1e-3, 1.0), clamp(2.0 * least, 1e-3, 1.0), fract(level));
    let wide = max(fwidth(alpha), edge);
    let share = clamp((alpha - 0.5) / wide + 0.5, 0.0, 1.0);
    // A picture of few pixels has no sides that one slope tells.
    let slope = vec2(dpdx(alpha), dpdy(alpha)) * ((1.0 - smoothstep(0.1, 0.3, pixel)) / wide);
    let holes = surface.piece > 0.0 && surface.layer >= 0;
    return select(vec3(1.0, 0.0, 0.0), vec3(share, slope), holes);
}

struct Masked {
    color: vec4<f32>,
    // See mask_share.
    share: vec3<f32>,
}

fn masked_color(in: Varyings) -> Masked {
    let surface = surface_of(in.material);
    let plain = vec4(tinted(in.color, surface), 1.0);
    let texel = select(plain, textured(in, surface), surface.layer >= 0);
    let share = mask_share(surface, texel.a, in.uv);
    return Masked(vec4(seen_radiance(in, texel.rgb), share.x), share);
}

// The samples that a share of a pixel covers: as many in the mean over leaves, and of each leaf others. What drivers
// make of alpha is their own, some of them always more.
fn covered_samples(in: Varyings, mask: vec3<f32>) -> u32 {
    let key = hash(in.material, 8u);
    let share = mask.x;
    if SAMPLES == 4u && frame.resolution < 1.0 {
        return samples_inside(mask, key);
    }
    // With one sample a leaf would be there or not as a whole.
    let noise = select(unit(key), fract(unit(key) + interleaved_noise(in.clip.xy)), SAMPLES == 1u);
    return some_samples(u32(f32(SAMPLES) * share + noise), key);
}

// Where samples become pixels of the picture: those that are on the leaf's side of the edge. Where the picture of the
// leaf is finer than a pixel, so that nothing tells the side, as many as the share says.
fn samples_inside(mask: vec3<f32>, key: u32) -> u32 {
    let known = abs(mask.y) + abs(mask.z);
    var samples = 0u;
    for (var i = 0u; i < 4u; i++) {
        let threshold = mix(fract(0.25 * f32(i) + unit(key)), 0.5, known);
        let there = mask.x + dot(mask.yz, SAMPLE_PLACES[i] - 0.5);
        samples |= select(0u, 1u << i, there > threshold);
    }
    return samples;
}

// So many of a pixel's samples, from one of them on.
fn some_samples(count: u32, first: u32) -> u32 {
    let turned = ((1u << count) - 1u) << (first % SAMPLES);
    return (turned | (turned >> SAMPLES)) & ((1u << SAMPLES) - 1u);
}

struct Faded {
    @location(0) color: vec4<f32>,
    @builtin(sample_mask) samples: u32,
}

// A hashed share of the samples, the same whatever is drawn first or behind.
fn seen_samples(in: Varyings) -> u32 {
    // By the place on the leaf, which stays as it is while the leaf moves.
    let place = vec2<u32>(vec2<i32>(floor(in.uv * 32.0)));
    let key = hash(hash(hash(in.material, 9u), place.x), place.y);
    let count = u32(in.contrast_seen_cosines.y * f32(SAMPLES) + unit(key));
    return some_samples(count, hash(key, 1u));
}

@fragment
fn solid_fade(in: Varyings) -> Faded {
    return Faded(solid_color(in), seen_samples(in));
}

@fragment
fn masked_fade(in: Varyings) -> Faded {
    let masked = masked_color(in);
    return Faded(id_or(masked.color, in), covered_samples(in, masked.share) & seen_samples(in));
}

@fragment
fn fade_shadow(in: Varyings) {
    let hole = shadow_hole(in);
    if hole || (seen_samples(in) & 1u) == 0u {
        discard;
    }
}
