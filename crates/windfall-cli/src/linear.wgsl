// From the samples of a picture to what compositing programs take: mean radiance, coverage, depth.

@group(0) @binding(0) var radiance: texture_multisampled_2d<f32>;
@group(0) @binding(1) var depth: texture_depth_multisampled_2d;
// Of each pixel: red and green, blue and alpha as halves, depth as bits.
@group(0) @binding(2) var<storage, read_write> pixels: array<u32>;
// Exposure, distance of the near plane, and 1 where the sky is to be clear.
@group(0) @binding(3) var<uniform> settings: vec4<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
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
    let first = 3u * (id.y * size.x + id.x);
    pixels[first] = pack2x16float(min(color.rg, vec2(65504.0)));
    pixels[first + 1u] = pack2x16float(vec2(min(color.b, 65504.0), color.a));
    // 1 at the near plane, 0 at infinity.
    pixels[first + 2u] = bitcast<u32>(select(3.0e38, settings.y / nearest, nearest > 0.0));
}
