// The occlusion pyramid: the farthest depth of ever larger squares. Depth is 1 near and 0 far.

@group(0) @binding(0) var depth: texture_depth_multisampled_2d;
@group(0) @binding(1) var below: texture_2d<f32>;
@group(0) @binding(2) var level: texture_storage_2d<r32float, write>;

// Two by two pixels, all samples. What is outside of the picture hides nothing and is never in the way.
@compute @workgroup_size(8, 8)
fn base(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(depth);
    var farthest = 1.0;
    for (var i = 0u; i < 4u; i++) {
        let at = 2u * id.xy + vec2(i & 1u, i >> 1u);
        if all(at < size) {
            for (var sample = 0; sample < i32(SAMPLES); sample++) {
                farthest = min(farthest, textureLoad(depth, at, sample));
            }
        }
    }
    textureStore(level, id.xy, vec4(farthest));
}

@compute @workgroup_size(8, 8)
fn reduce(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(below);
    var farthest = 1.0;
    for (var i = 0u; i < 4u; i++) {
        let at = min(2u * id.xy + vec2(i & 1u, i >> 1u), size - 1u);
        farthest = min(farthest, textureLoad(below, at, 0).r);
    }
    textureStore(level, id.xy, vec4(farthest));
}
