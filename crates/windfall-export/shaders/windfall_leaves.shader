// Unity: leaves of a Windfall vertex animation texture, for the built-in pipeline. Set the properties from the sidecar;
// import both textures without sRGB, mip maps, filtering and compression. `windfall_vat.hlsl` lies beside this file.
Shader "Windfall/Leaves"
{
    Properties
    {
        _PositionTexture ("Positions", 2D) = "black" {}
        _RotationTexture ("Rotations", 2D) = "black" {}
        _PositionLow ("Position low", Vector) = (0, 0, 0, 0)
        _PositionHigh ("Position high", Vector) = (1, 1, 1, 1)
        _RotationLow ("Rotation low", Float) = 0
        _RotationHigh ("Rotation high", Float) = 1
        _Frames ("Frames", Float) = 1
        _Fps ("Frames a second", Float) = 30
    }
    SubShader
    {
        Tags { "RenderType" = "Opaque" }
        Cull Off
        Pass
        {
            HLSLPROGRAM
            #pragma vertex vertex
            #pragma fragment fragment
            #include "UnityCG.cginc"
            #include "windfall_vat.hlsl"

            sampler2D _PositionTexture;
            sampler2D _RotationTexture;
            float4 _PositionTexture_TexelSize;
            float4 _PositionLow, _PositionHigh;
            float _RotationLow, _RotationHigh, _Frames, _Fps;

            struct Corner
            {
                float4 position : POSITION;
                float3 normal : NORMAL;
                float4 color : COLOR;
                float2 address : TEXCOORD1;
            };

            struct Drawn
            {
                float4 position : SV_POSITION;
                float3 normal : TEXCOORD0;
                float4 color : COLOR;
            };

            // Rows of a texture count from the bottom in Unity, from the top in the file.
            float4 Read(sampler2D from, float2 address, float frame)
            {
                float2 at = windfall_texel(address, frame, _PositionTexture_TexelSize.w);
                return tex2Dlod(from, float4(at.x, 1 - at.y, 0, 0));
            }

            Drawn vertex(Corner corner)
            {
                float3 at = windfall_frames(fmod(_Time.y, _Frames / _Fps), _Fps, _Frames);
                float4 low = float4(_PositionLow.xyz, 0), high = float4(_PositionHigh.xyz, 1);
                float4 a = windfall_decode(Read(_PositionTexture, corner.address, at.x), low, high);
                float4 b = windfall_decode(Read(_PositionTexture, corner.address, at.y), low, high);
                float4 q = windfall_between(
                    windfall_decode(Read(_RotationTexture, corner.address, at.x), _RotationLow, _RotationHigh),
                    windfall_decode(Read(_RotationTexture, corner.address, at.y), _RotationLow, _RotationHigh),
                    at.z);
                Drawn drawn;
                float3 place = windfall_vertex(corner.position.xyz, a, b, q, at.z);
                drawn.position = UnityObjectToClipPos(float4(place, 1));
                drawn.normal = UnityObjectToWorldNormal(windfall_rotate(q, corner.normal));
                drawn.color = corner.color;
                return drawn;
            }

            float4 fragment(Drawn drawn) : SV_Target
            {
                float light = 0.35 + 0.65 * abs(dot(normalize(drawn.normal), _WorldSpaceLightPos0.xyz));
                return float4(drawn.color.rgb * light, 1);
            }
            ENDHLSL
        }
    }
}
