// Listing 13: the trims, and the lighting of listing 7 (common/phong.glsl).

layout(location = 0) in vec3 passNormal;
layout(location = 1) in vec2 passTessCoord;
layout(location = 2) in vec4 position;
layout(location = 4) in vec2 passUVCoord;

layout(binding = 0) uniform sampler2D colortexture;

out vec4 fragmentColor;

#ifdef FAR_DEPTH
// Depth is proportional to the distance along the view axis, so its relative precision is the same
// at every distance.
layout(location = 32) uniform float depthScale;
#endif

void main()
{
#ifdef STUDIO
    vec3 upright = uprightAt(position.xyz);
#endif
    // Sampled before any fragment is discarded: the mipmap level is computed from neighbouring
    // pixels.
    vec4 texel = texture(colortexture, passUVCoord);
    vec3 diffuseColor = texel.rgb;
#ifdef CUT_OUT
    if (texel.a < 0.5)
        discard;
#endif
#ifdef TRIMMED
    if (cut(passTessCoord))
        discard;
#endif
#if defined(STUDIO)
    fragmentColor = vec4(lit(linearOf(diffuseColor), position.xyz, passNormal, upright), 1.0);
#elif defined(PHONG)
    fragmentColor = vec4(lit(diffuseColor, position.xyz, passNormal), 1.0);
#elif defined(NORMALS)
    float size = length(passNormal);
    fragmentColor = vec4(0.5 * (size > 0.0 ? passNormal / size : vec3(0.0)) + 0.5, 1.0);
#else
    fragmentColor = vec4(diffuseColor, 1.0);
#endif
#ifdef FAR_DEPTH
    gl_FragDepth = -position.z * depthScale;
#endif
}
