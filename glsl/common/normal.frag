// The normal at a pixel: that of the surface if PIXEL_NORMALS is defined, otherwise interpolated
// from the vertices of the triangle, and then not of unit length.

#ifdef PIXEL_NORMALS
#ifdef SHARED
layout(binding = 4) uniform samplerBuffer surfaces;
#else
layout(location = 29) uniform mat4 normalToView;
#endif

#ifdef GEOMETRY
layout(location = 13) flat in uvec4 passPlace;
#else
layout(location = 4) flat in uvec4 passPlace;
#endif
#if defined(DEGENERATE) && defined(GEOMETRY)
layout(location = 14) flat in vec2 passLongest;
#elif defined(DEGENERATE)
layout(location = 5) flat in vec2 passLongest;
#endif

// View space, unit length.
vec3 normalAt(vec2 uv)
{
    vec2 t = clamp(uv, 0.0, 1.0), s = 1.0 - t;
#ifdef ANY_DEGREE
    COLUMNS = int(passPlace.w & 0xffu);
    ROWS = int(passPlace.w >> 8);
#endif
    PATCH points;
    fetchPatch(int(passPlace.x), points);
    vec4 point;
    POINT du, dv;
    evaluate(points, t, s, point, du, dv);
#ifdef DEGENERATE
    vec3 crossed = patchNormal(points, t, s, point, du, dv, passLongest);
#else
    vec3 crossed = cross(tangent(point, dv), tangent(point, du));
#endif
#ifdef SHARED
    int columns = int(passPlace.z) * 12 + 8;
    vec3 normal = texelFetch(surfaces, columns).xyz * crossed.x
        + texelFetch(surfaces, columns + 1).xyz * crossed.y
        + texelFetch(surfaces, columns + 2).xyz * crossed.z;
#else
    vec3 normal = mat3(normalToView) * crossed;
#endif
    float size = dot(normal, normal);
    return size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
}
#else
layout(location = 0) in vec3 passNormal;

vec3 normalAt(vec2 uv)
{
    return passNormal;
}
#endif
