// Isolines: lines of equal u and of equal v on a surface. A pixel gets the colour of a line by the share of it that the
// line covers.
//
// The triangles tell (u, v) near the pixel. The true patch is evaluated there, and its tangents tell where the line is
// that passes by. So a line lies where the surface has it, wherever the triangles lie within the tolerance.

layout(location = 26) uniform vec4 viewport; // first pixel, half of width and height
layout(location = 42) uniform vec2 isolines; // lines of each direction, half of the width in pixels
layout(location = 43) uniform vec3 isolineColor;
layout(binding = 7) uniform samplerBuffer domains; // for each patch: first u and v, length along u and v

#ifndef PIXEL_NORMALS
layout(location = 4) flat in uvec4 passPlace;
#ifdef SHARED
layout(binding = 4) uniform samplerBuffer surfaces;
#endif
#endif
#ifndef SHARED
layout(location = 27) uniform mat4 toClip;
#endif

// Only lines that are at most so many times half of their width away on the surface, as the tangents tell it, are drawn:
// near silhouettes, tangents tell nothing about what is far away.
const float REACH = 16.0;

// How far a line lies beside a pixel that is `off` from a point, in pixels, if a step `across` leads from the point to
// the line, which runs `along`.
float beside(vec2 off, vec2 across, vec2 along)
{
    float size = dot(along, along);
    float reach = REACH * (isolines.y + 0.5);
    // At a pole, the line is a point.
    if (!(size > 0.0) || dot(across, across) > reach * reach + 4.0 * dot(off, off))
        return 1e30;
    vec2 left = off - across;
    return abs(left.x * along.y - left.y * along.x) * inversesqrt(size);
}

// The share of a pixel at (u, v) of the patch that lines cover, from 0 to 1.
float isolineShare(vec2 uv)
{
    vec2 t = clamp(uv, 0.0, 1.0), s = 1.0 - t;
#ifdef SHARED
    int columns = int(passPlace.z) * 12;
    mat4 toClip = mat4(texelFetch(surfaces, columns), texelFetch(surfaces, columns + 1),
        texelFetch(surfaces, columns + 2), texelFetch(surfaces, columns + 3));
#endif
#ifdef ANY_DEGREE
    COLUMNS = int(passPlace.w & 0xffu);
    ROWS = int(passPlace.w >> 8);
#endif
    PATCH points;
    fetchPatch(int(passPlace.x), points);
    vec4 point;
    POINT du, dv;
    evaluate(points, t, s, point, du, dv);
    // On the screen, in pixels from the middle of the viewport.
    vec3 clip = (toClip * point).xyw;
#ifdef RATIONAL
    vec3 clipU = (toClip * du).xyw, clipV = (toClip * dv).xyw;
#else
    vec3 clipU = (toClip * vec4(du, 0.0)).xyw, clipV = (toClip * vec4(dv, 0.0)).xyw;
#endif
    vec2 place = clip.xy / clip.z;
    vec2 alongU = viewport.zw * (clipU.xy - place * clipU.z) / clip.z;
    vec2 alongV = viewport.zw * (clipV.xy - place * clipV.z) / clip.z;
    vec2 off = gl_FragCoord.xy - viewport.xy - viewport.zw * (1.0 + place);

    // The nearest lines, and the steps to them in the parameters of the patch.
    vec4 domain = texelFetch(domains, int(passPlace.y));
    vec2 number = clamp(floor((domain.xy + t * domain.zw) * isolines.x), 0.0, isolines.x - 1.0);
    vec2 steps = ((number + 0.5) / isolines.x - domain.xy) / domain.zw - t;
    float off_line = min(beside(off, steps.x * alongU, alongV), beside(off, steps.y * alongV, alongU));
    return clamp(isolines.y + 0.5 - off_line, 0.0, min(1.0, 2.0 * isolines.y));
}
