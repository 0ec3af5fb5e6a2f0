// The patch that a pixel shows, evaluated in the fragment stage (EVALUATED).

#ifdef GEOMETRY
layout(location = 13) flat in uvec4 passPlace; // first control point, patch, surface, columns | rows << 8
#else
layout(location = 4) flat in uvec4 passPlace;
#endif
#if defined(DEGENERATE) && defined(GEOMETRY)
layout(location = 14) flat in vec2 passLongest;
#elif defined(DEGENERATE)
layout(location = 5) flat in vec2 passLongest;
#endif

#ifdef SHARED
layout(binding = 4) uniform samplerBuffer surfaces;
#else
layout(location = 27) uniform mat4 toClip;
layout(location = 28) uniform mat4 toView;
layout(location = 29) uniform mat4 normalToView;
#endif
layout(location = 26) uniform vec4 viewport; // first pixel, half of width and height

#ifdef SHARED
mat4 matrixOfSurface(int column)
{
    int first = int(passPlace.z) * 12 + column;
    return mat4(texelFetch(surfaces, first), texelFetch(surfaces, first + 1), texelFetch(surfaces, first + 2),
        texelFetch(surfaces, first + 3));
}
#define MATRIX(uniformName, column) matrixOfSurface(column)
#else
#define MATRIX(uniformName, column) uniformName
#endif

// The index of the first control point of the pixel's patch.
int firstPointOfPixel()
{
#ifdef ANY_DEGREE
    COLUMNS = int(passPlace.w & 0xffu);
    ROWS = int(passPlace.w >> 8);
#endif
    return int(passPlace.x);
}

// A point of the patch as the picture shows it, in pixels from the middle of the viewport, and its derivatives along u
// and v.
struct Seen {
    vec2 place;
    vec2 along[2];
    bool isBefore; // in front of the eye
};

Seen see(mat4 clipping, vec4 point, POINT du, POINT dv)
{
    vec3 clip = (clipping * point).xyw;
#ifdef RATIONAL
    vec3 clipU = (clipping * du).xyw, clipV = (clipping * dv).xyw;
#else
    vec3 clipU = (clipping * vec4(du, 0.0)).xyw, clipV = (clipping * vec4(dv, 0.0)).xyw;
#endif
    vec2 place = clip.xy / clip.z;
    vec2 along[2] = vec2[](viewport.zw * (clipU.xy - place * clipU.z) / clip.z,
        viewport.zw * (clipV.xy - place * clipV.z) / clip.z);
    return Seen(viewport.zw * place, along, clip.z > 0.0);
}

// The pixel's centre, or the sample where each is shaded, in pixels from the middle of the viewport.
vec2 pixelPlace()
{
    return gl_FragCoord.xy - viewport.xy - viewport.zw;
}
