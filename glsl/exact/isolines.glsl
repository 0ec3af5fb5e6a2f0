// Isolines: lines of equal u and of equal v on a surface. A pixel gets the colour of a line by the share of it that the
// line covers.
//
// The triangles tell (u, v) near the pixel. The true patch is evaluated there, and where its tangents say that the line
// passes by. So a line lies where the surface has it, wherever the triangles lie within the tolerance.

layout(location = 42) uniform vec2 isolines; // lines of each direction, half of the width in pixels
layout(location = 43) uniform vec3 isolineColor;
layout(binding = 7) uniform samplerBuffer domains; // for each patch: first u and v, length along u and v

// A line is looked for at most so many times half of its width away.
const float REACH = 16.0;

Seen seeAt(mat4 clipping, PATCH points, vec2 t)
{
    vec4 point;
    POINT du, dv;
    evaluate(points, t, 1.0 - t, point, du, dv);
    return see(clipping, point, du, dv);
}

// The share of a pixel at (u, v) of the patch that lines cover, from 0 to 1.
float isolineShare(vec2 uv)
{
    vec2 t = clamp(uv, 0.0, 1.0);
    mat4 clipping = MATRIX(toClip, 0);
    PATCH points;
    fetchPatch(firstPointOfPixel(), points);
    vec2 pixel = pixelPlace();
    Seen here = seeAt(clipping, points, t);
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
        Seen there = seeAt(clipping, points, foot);
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
