// Isolines: lines of equal u and of equal v on a surface. A pixel gets the colour of a line by the share of it that the
// line covers.
//
// The triangles tell (u, v) near the pixel. The true patch is evaluated there, and where its tangents say that the line
// passes by. So a line lies where the surface has it, wherever the triangles lie within the tolerance.

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

// A line is looked for at most so many times half of its width away.
const float REACH = 16.0;

// A point of the patch as the picture shows it, in pixels from the middle of the viewport, and its derivatives along u
// and v.
struct Seen {
    vec2 place;
    vec2 along[2];
    bool isBefore; // in front of the eye
};

Seen see(mat4 toClip, PATCH points, vec2 t)
{
    vec4 point;
    POINT du, dv;
    evaluate(points, t, 1.0 - t, point, du, dv);
    vec3 clip = (toClip * point).xyw;
#ifdef RATIONAL
    vec3 clipU = (toClip * du).xyw, clipV = (toClip * dv).xyw;
#else
    vec3 clipU = (toClip * vec4(du, 0.0)).xyw, clipV = (toClip * vec4(dv, 0.0)).xyw;
#endif
    vec2 place = clip.xy / clip.z;
    vec2 along[2] = vec2[](viewport.zw * (clipU.xy - place * clipU.z) / clip.z,
        viewport.zw * (clipV.xy - place * clipV.z) / clip.z);
    return Seen(viewport.zw * place, along, clip.z > 0.0);
}

// The share of a pixel at (u, v) of the patch that lines cover, from 0 to 1.
float isolineShare(vec2 uv)
{
    vec2 t = clamp(uv, 0.0, 1.0);
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
    vec2 pixel = gl_FragCoord.xy - viewport.xy - viewport.zw;
    Seen here = see(toClip, points, t);
    vec2 off = pixel - here.place;

    // The nearest lines, and the steps to them in the parameters of the patch.
    vec4 domain = texelFetch(domains, int(passPlace.y));
    vec2 number = clamp(floor((domain.xy + t * domain.zw) * isolines.x), 0.0, isolines.x - 1.0);
    vec2 steps = ((number + 0.5) / isolines.x - domain.xy) / domain.zw - t;

    vec2 first = -domain.xy / domain.zw, last = (1.0 - domain.xy) / domain.zw; // of the surface

    float halfWidth = isolines.y + 0.5; // with half of a pixel
    float nearest = 1e30;
    for (int i = 0; i < 2; ++i) {
        // By the tangents here, the point of the line that is nearest to the pixel. Tangents are right about what is
        // near, but at a silhouette everything along it seems near: the point is evaluated. It may be in the next patch,
        // of which this one tells enough, but not beyond the surface.
        vec2 across = steps[i] * here.along[i], along = here.along[1 - i];
        float far = dot(across, across) - 4.0 * dot(off, off);
        float size = dot(along, along);
        if (!(size > 0.0) || far > REACH * REACH * halfWidth * halfWidth)
            continue;
        vec2 foot = t;
        foot[i] += steps[i];
        foot[1 - i] += dot(off - across, along) / size;
        foot[1 - i] = clamp(foot[1 - i], first[1 - i], last[1 - i]);
        Seen there = see(toClip, points, foot);
        vec2 left = pixel - there.place;
        along = there.along[1 - i];
        size = dot(along, along);
        if (!there.isBefore || !(size > 0.0))
            continue;
        along *= inversesqrt(size);
        // Where the line bends much, the point is not the nearest one; and the line may end there.
        float beyond = abs(dot(left, along)) - length(off) - 1.0;
        nearest = min(nearest, max(abs(left.x * along.y - left.y * along.x), beyond));
    }
    return clamp(halfWidth - nearest, 0.0, min(1.0, 2.0 * isolines.y));
}
