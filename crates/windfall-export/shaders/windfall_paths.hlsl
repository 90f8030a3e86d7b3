// Generated from windfall_paths.wgsl by naga: do not edit.

float3 windfall_path_times(float elapsed, float4 fall, float4 variant, float soft, float settle)
{
    float now = clamp(elapsed, 0.0, fall.w);
    float settles = clamp(settle, 0.0, fall.w);
    float done_2 = clamp((1.0 - ((fall.w - now) / max(settles, 1e-6))), 0.0, 1.0);
    float turning = ((done_2 > 0.0) ? ((fall.w - settles) + (settles * (done_2 - ((0.5 * done_2) * done_2)))) : now);
    float2 t = float2(now, turning);
    float2 early = ((t * t) / (max((2.0 * soft), 1e-6)).xx);
    float2 late = (t - ((0.5 * max(soft, 0.0))).xx);
    return float3((((t < (soft).xx) ? early : late) * variant.w), done_2);
}

float windfall_smooth(float x)
{
    float s = clamp(x, 0.0, 1.0);
    return ((s * s) * (3.0 - (2.0 * s)));
}

float4 windfall_multiply(float4 a, float4 b)
{
    return float4((((a.w * b.xyz) + (b.w * a.xyz)) + cross(a.xyz, b.xyz)), ((a.w * b.w) - dot(a.xyz, b.xyz)));
}

float4 windfall_part(float4 q, float share)
{
    float4 nearer = ((q.w < 0.0) ? -(q) : q);
    float angle = acos(min(nearer.w, 1.0));
    float3 along_1 = (nearer.xyz / (max(sqrt(max((1.0 - (nearer.w * nearer.w)), 0.0)), 1e-6)).xxx);
    return float4((along_1 * sin((angle * share))), cos((angle * share)));
}

float windfall_drift(float elapsed_1, float fall_time, float response)
{
    float lag = max(response, 0.0001);
    float whole = (fall_time - (lag * (1.0 - exp((-(fall_time) / lag)))));
    return ((elapsed_1 - (lag * (1.0 - exp((-(elapsed_1) / lag))))) / max(whole, 1e-6));
}

float3 windfall_path_place(float elapsed_2, float4 twig, float4 fall_1, float4 variant_1, float4 wind, float3 along, float done, float response_1)
{
    float now_1 = clamp(elapsed_2, 0.0, fall_1.w);
    float s_1 = sin(variant_1.x);
    float c = cos(variant_1.x);
    float2 scaled = float2((along.x * variant_1.y), (along.z * variant_1.z));
    float3 turned = float3(((c * scaled.x) + (s_1 * scaled.y)), along.y, ((c * scaled.y) - (s_1 * scaled.x)));
    const float _e39 = windfall_drift(now_1, fall_1.w, response_1);
    float3 blown = (float3(wind.x, 0.0, wind.y) * _e39);
    const float _e45 = windfall_smooth(done);
    return (((twig.xyz + turned) + blown) + float3(0.0, (wind.w * _e45), 0.0));
}

float4 windfall_path_rotation(float4 from_twig, float4 settle_1, float4 variant_2, float4 on_path, float drop, float soft_drop, float done_1)
{
    float4 yaw = float4(0.0, sin((0.5 * variant_2.x)), 0.0, cos((0.5 * variant_2.x)));
    const float _e21 = windfall_smooth((drop / max(soft_drop, 1e-6)));
    float eased = ((soft_drop > 0.0) ? _e21 : 1.0);
    const float4 _e26 = windfall_multiply(yaw, on_path);
    const float4 _e29 = windfall_part(from_twig, (1.0 - eased));
    const float4 _e30 = windfall_multiply(_e26, _e29);
    const float _e31 = windfall_smooth(done_1);
    const float4 _e32 = windfall_part(settle_1, _e31);
    const float4 _e33 = windfall_multiply(_e30, _e32);
    return _e33;
}

