// Generated from windfall_vat.wgsl by naga: do not edit.

float4 windfall_decode(float4 texel, float4 low, float4 high)
{
    return (low + (texel * (high - low)));
}

float3 windfall_frames(float seconds, float fps, float frames)
{
    float at = clamp((seconds * fps), 0.0, (frames - 1.0));
    float first = floor(at);
    return float3(first, min((first + 1.0), (frames - 1.0)), (at - first));
}

float2 windfall_texel(float2 address, float at_frame, float height)
{
    return float2(address.x, (address.y + (at_frame / height)));
}

float3 windfall_rotate(float4 q, float3 v)
{
    float3 t = (2.0 * cross(q.xyz, v));
    return ((v + (q.w * t)) + cross(q.xyz, t));
}

float4 windfall_between(float4 a, float4 b, float share)
{
    float4 nearer = ((dot(a, b) < 0.0) ? -(b) : b);
    return normalize(lerp(a, nearer, share));
}

float3 windfall_vertex(float3 local, float4 place_a, float4 place_b, float4 rotation, float share_1)
{
    const float3 _e8 = windfall_rotate(rotation, local);
    return (lerp(place_a.xyz, place_b.xyz, share_1) + (_e8 * place_a.w));
}

