// From radiance to the picture, as a camera and a screen together do: with more contrast than the
// scene, since a picture is seen in a dimmer surround than a wood in the sun (the system gamma of ITU-R
// BT.2100: a power of the luminance, about the grey of a card, which keeps hues). Then what is bright is
// drawn together by the Khronos PBR neutral curve (2024), without its toe, which takes a surface's Fresnel
// reflection off and would make the shade of a wood black.

@group(1) @binding(0) var radiance: texture_multisampled_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

const SYSTEM_GAMMA: f32 = 1.2;
const GREY: f32 = 0.18;

fn system(color: vec3<f32>) -> vec3<f32> {
    let luminance = max(dot(color, vec3(0.2126, 0.7152, 0.0722)), 1e-6);
    return color * pow(luminance / GREY, SYSTEM_GAMMA - 1.0);
}

fn neutral(color: vec3<f32>) -> vec3<f32> {
    let start_compression = 0.62;
    let desaturation = 0.06;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start_compression {
        return color;
    }
    let d = 1.0 - start_compression;
    let new_peak = 1.0 - d * d / (peak + d - start_compression);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3(new_peak), g);
}

// Samples that a pixel is made of: its own four, and of each neighbour the one that lies nearest, 5/8
// from the pixel's centre. Where four samples are (the pattern of Direct3D, which the others have too) the
// tent filter gives the latter 0.6 of the weight of its own.
const NEIGHBOURS = array<vec3<i32>, 4>(vec3(1, 0, 2), vec3(0, 1, 0), vec3(-1, 0, 1), vec3(0, -1, 3));
const NEIGHBOUR_WEIGHT: f32 = 0.6;

fn tone_mapped(linear: vec3<f32>) -> vec3<f32> {
    if explains() {
        return linear;
    }
    if frame.show == SHOW_RADIANCE {
        return linear * frame.exposure;
    }
    if frame.show == SHOW_IDS {
        return id_color(linear);
    }
    return max(neutral(system(linear * frame.exposure)), vec3(0.0));
}

// A colour for the digits of an id; leaves are counted from 1, so that nothing is black.
fn id_color(digits: vec3<f32>) -> vec3<f32> {
    let key = hash(hash(u32(digits.x), u32(digits.y)), u32(digits.z));
    let color = vec3(unit(key), unit(hash(key, 1u)), unit(hash(key, 2u)));
    return select(vec3(0.0), 0.08 + 0.92 * color * color, digits.x + digits.y > 0.0);
}

fn sample_color(at: vec2<i32>, i: i32) -> vec3<f32> {
    return tone_mapped(textureLoad(radiance, at, i).rgb);
}

// Straight alpha: the mean of those samples alone that are not sky, which has none.
fn without_sky(pixel: vec2<i32>) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        let texel = textureLoad(radiance, pixel, i);
        if texel.a > 0.0 {
            sum += vec4(tone_mapped(texel.rgb), 1.0);
        }
    }
    return vec4(sum.rgb / max(sum.a, 1.0), sum.a * 0.25);
}

// A picture whose scene was drawn with fewer pixels: in the square of one of those about a place lie four samples,
// one of each kind; the nearer, the more each weighs.
@fragment
fn enlarged(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = at.xy * frame.resolution;
    let last = vec2<i32>(ceil(vec2(frame.width, frame.height) * frame.resolution)) - 1;
    var sum = vec3(0.0);
    var weights = 0.0;
    var covered = 0.0;
    // The larger a pixel of the scene, the more its samples' pattern would show as a comb: there they are mixed.
    let steep = mix(0.6, 4.0, smoothstep(0.3, 0.5, frame.resolution));
    for (var i = 0; i < 4; i++) {
        let pixel = floor(place - SAMPLE_PLACES[i] + 0.5);
        let away = abs(pixel + SAMPLE_PLACES[i] - place);
        // Within the pixel of the picture all weigh the same, so that at full resolution it is their mean.
        let beyond = clamp(steep * (away - 0.5 * frame.resolution), vec2(0.0), vec2(0.98));
        let weight = (1.0 - beyond.x) * (1.0 - beyond.y);
        let texel = textureLoad(radiance, clamp(vec2<i32>(pixel), vec2(0), last), i);
        let alpha = select(1.0, texel.a, has(TRANSPARENT_SKY));
        sum += weight * alpha * tone_mapped(texel.rgb);
        covered += weight * alpha;
        weights += weight;
    }
    if has(TRANSPARENT_SKY) {
        return vec4(sum / max(covered, 1e-4), covered / weights);
    }
    return encoded(sum / weights, at.xy);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    // The curve before the mean: of a leaf before a bright sky the edge would else be all sky as soon
    // as one sample is.
    let pixel = vec2<i32>(at.xy);
    if has(TRANSPARENT_SKY) {
        return without_sky(pixel);
    }
    var color = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        color += sample_color(pixel, i);
    }
    color *= 0.25;
    if has(RESOLVE_FILTER) {
        let last = vec2<i32>(textureDimensions(radiance)) - 1;
        var around = vec3(0.0);
        for (var i = 0; i < 4; i++) {
            let neighbour = NEIGHBOURS[i];
            around += sample_color(clamp(pixel + neighbour.xy, vec2(0), last), neighbour.z);
        }
        color = (color + around * (0.25 * NEIGHBOUR_WEIGHT)) / (1.0 + NEIGHBOUR_WEIGHT);
    }
    return encoded(color, at.xy);
}

fn encoded(color: vec3<f32>, at: vec2<f32>) -> vec4<f32> {
    if explains() || frame.show == SHOW_RADIANCE || frame.show == SHOW_IDS {
        return vec4(color, 1.0);
    }
    // Half a step of the encoded picture either way breaks the bands that a smooth sky would have. A square root is near
    // enough to the encoding.
    let noise = (interleaved_noise(at) - 0.5) / 255.0;
    let root = max(sqrt(color) + noise, vec3(0.0));
    return vec4(root * root, 1.0);
}
