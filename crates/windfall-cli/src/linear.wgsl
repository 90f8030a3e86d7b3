// From the samples of a picture to what compositing programs take: mean radiance, coverage, depth.

@group(0) @binding(0) var radiance: texture_multisampled_2d<f32>;
@group(0) @binding(1) var depth: texture_depth_multisampled_2d;
// Of each pixel: red and green, blue and alpha as halves, depth as bits. Where leaves are told apart two more: the
// leaf that is seen and its tree, both counted from 1; 0 where none is.
@group(0) @binding(2) var<storage, read_write> pixels: array<u32>;
// Exposure, distance of the near plane, 1 where the sky is to be clear, words of a pixel.
@group(0) @binding(3) var<uniform> settings: vec4<f32>;

@compute @workgroup_size(8, 8)
fn colors(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(radiance);
    if id.x >= size.x || id.y >= size.y {
        return;
    }
    var sum = vec4(0.0);
    var nearest = 0.0;
    for (var i = 0; i < 4; i++) {
        let texel = textureLoad(radiance, vec2<i32>(id.xy), i);
        // The sky has no alpha where it is to be clear.
        if settings.z == 0.0 || texel.a > 0.0 {
            sum += vec4(texel.rgb, 1.0);
        }
        nearest = max(nearest, textureLoad(depth, vec2<i32>(id.xy), i));
    }
    // Premultiplied, as EXR has it.
    let color = sum * 0.25 * vec4(vec3(settings.x), 1.0);
    let first = u32(settings.w) * (id.y * size.x + id.x);
    pixels[first] = pack2x16float(min(color.rg, vec2(65504.0)));
    pixels[first + 1u] = pack2x16float(vec2(min(color.b, 65504.0), color.a));
    // 1 at the near plane, 0 at infinity.
    pixels[first + 2u] = bitcast<u32>(select(3.0e38, settings.y / nearest, nearest > 0.0));
}

// From a picture of leaves alone (windfall_gpu::DebugView::Ids), after `colors` of the whole: the nearest leaf, if
// nothing is before it.
@compute @workgroup_size(8, 8)
fn ids(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(radiance);
    if id.x >= size.x || id.y >= size.y {
        return;
    }
    var nearest = 0.0;
    var sample = 0;
    for (var i = 0; i < 4; i++) {
        let depth = textureLoad(depth, vec2<i32>(id.xy), i);
        sample = select(sample, i, depth > nearest);
        nearest = max(nearest, depth);
    }
    let digits = vec4<u32>(textureLoad(radiance, vec2<i32>(id.xy), sample));
    let first = u32(settings.w) * (id.y * size.x + id.x);
    // The whole may have placed the leaf's corners in another way: rounding differs.
    let seen = settings.y / nearest <= bitcast<f32>(pixels[first + 2u]) * 1.0001 && nearest > 0.0;
    pixels[first + 3u] = select(0u, digits.x + (digits.y << 11u), seen);
    pixels[first + 4u] = select(0u, digits.z + (digits.w << 11u) + 1u, seen);
}
