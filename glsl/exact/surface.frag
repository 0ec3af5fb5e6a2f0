// Light, or an analysis in its place. Trims are decided at the (u, v) of each sample.
//
// SAMPLES is the number of samples per pixel of the target. With ANALYSIS, each sample has its own colour.

layout(location = 1) in vec2 passTessCoord;
layout(location = 2) in vec4 position;
#ifdef COLORED
layout(location = 6) in vec3 passColor; // interpolated from the vertices of a mesh
#endif

#if defined(OVER_DOMAIN)
layout(location = 8) in vec2 passPictureCoord; // (u, v) in the domain of the surface, from 0 to 1
#elif !defined(TEXTURED) && (defined(SHARED) || defined(STUDIO))
layout(location = 8) flat in vec3 passPaint; // the surface's colour; linear with STUDIO
#elif !defined(TEXTURED)
layout(location = 36) uniform vec3 passPaint; // the surface's colour
#endif

#ifdef TEXTURED
layout(binding = 0) uniform sampler2D colortexture;
#endif

out vec4 fragmentColor;

#ifdef FAR_DEPTH
// Depth is proportional to the distance along the view axis, so its relative precision is the same
// at every distance.
layout(location = 32) uniform float depthScale;
#endif

void main()
{
#if defined(ANALYSIS) && SAMPLES > 1
    // The use of gl_SampleID makes the stage run for each sample.
    vec2 tessCoord = interpolateAtSample(passTessCoord, gl_SampleID);
    vec3 place = interpolateAtSample(position, gl_SampleID).xyz;
#else
    vec2 tessCoord = passTessCoord;
    vec3 place = position.xyz;
#endif
    vec2 uv = clamp(tessCoord, 0.0, 1.0);
    // What has derivatives comes before anything is discarded.
#if defined(ZEBRA)
    vec3 analysed = zebra(place, normalAt(tessCoord));
#elif defined(ISOPHOTES)
    vec3 analysed = isophotes(normalAt(tessCoord));
#elif defined(DRAFT)
    vec3 analysed = draft(place, normalAt(tessCoord));
#elif defined(CURVATURE)
    vec3 normal;
    vec3 curvature = curvatureAt(tessCoord, normal);
    vec3 analysed = curvatureColor(curvature, place, normal);
#elif defined(STUDIO)
    vec3 upright = uprightAt(position.xyz);
#endif
#ifdef TEXTURED
#ifdef OVER_DOMAIN
    vec2 pictureCoord = passPictureCoord;
#else
    vec2 pictureCoord = passTessCoord;
#endif
    // Sampled before any fragment is discarded: the mipmap level is computed from neighbouring
    // pixels.
    vec4 texel = texture(colortexture, pictureCoord);
    vec3 diffuseColor = texel.rgb;
#else
    vec3 diffuseColor = passPaint;
#endif
#ifdef CUT_OUT
    if (texel.a < 0.5)
        discard;
#endif
#ifdef COLORED
    diffuseColor *= passColor;
#endif
#if defined(STUDIO) && defined(TEXTURED)
    diffuseColor = linearOf(diffuseColor);
#endif
#if defined(TRIMMED) && SAMPLES > 1 && !defined(ANALYSIS)
    int kept = 0;
    for (int i = 0; i < SAMPLES; ++i)
        if (!cut(interpolateAtSample(passTessCoord, i)))
            kept |= 1 << i;
    if (kept == 0)
        discard;
    gl_SampleMask[0] = kept;
#elif defined(TRIMMED)
    if (cut(tessCoord))
        discard;
#endif
#ifdef ANALYSIS
    fragmentColor = vec4(analysed, 1.0);
#elif defined(STUDIO)
    fragmentColor = vec4(lit(diffuseColor, place, normalAt(uv), upright), 1.0);
#elif defined(PHONG)
    fragmentColor = vec4(lit(diffuseColor, place, normalAt(uv)), 1.0);
#elif defined(NORMALS)
    vec3 normal = normalAt(uv);
    float size = length(normal);
    fragmentColor = vec4(0.5 * (size > 0.0 ? normal / size : vec3(0.0)) + 0.5, 1.0);
#else
    fragmentColor = vec4(diffuseColor, 1.0);
#endif
#ifdef ISOLINES
    fragmentColor.rgb = mix(fragmentColor.rgb, isolineColor, isolineShare(passTessCoord));
#endif
#ifdef FAR_DEPTH
    gl_FragDepth = -position.z * depthScale;
#endif
}
