// Report, section 2.4: the texture without lighting, red wireframe lines, or blue control points.

in TES_OUT {
    vec2 texCoord;
} fs_in;
#ifdef FAR_DEPTH
layout(location = 2) in vec4 position; // view space
#endif

out vec4 FragColor;

#ifdef FAR_DEPTH
// Depth is proportional to the distance along the view axis, so its relative precision is the same
// at every distance.
layout(location = 32) uniform float depthScale;
#endif

layout(binding = 0) uniform sampler2D textureSurface;
layout(location = 21) uniform bool wireframe;
layout(location = 22) uniform bool showControlPoints;

void main()
{
    vec4 color = texture(textureSurface, fs_in.texCoord);
#ifdef CUT_OUT
    if (color.a < 0.5)
        discard;
#endif
#ifdef TRIMMED
    if (cut(fs_in.texCoord))
        discard;
#endif
    if (showControlPoints)
        color = vec4(0.0, 0.5, 1.0, 1.0);
    else if (wireframe)
        color = vec4(1.0, 0.0, 0.0, 1.0);
    FragColor = vec4(color.rgb, 1.0);
#ifdef FAR_DEPTH
    gl_FragDepth = -position.z * depthScale;
#endif
}
