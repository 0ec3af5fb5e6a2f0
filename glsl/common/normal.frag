// The normal at a pixel: that of the surface if PIXEL_NORMALS is defined, otherwise interpolated
// from the vertices of the triangle, and then not of unit length.

#ifdef PIXEL_NORMALS
// View space, unit length.
vec3 normalAt(vec2 uv)
{
    PATCH points;
    fetchPatch(firstPointOfPixel(), points);
#ifdef DEGENERATE
    vec3 crossed = normalOf(evaluateCurved(points, uv), uv, passLongest);
#else
    vec4 point;
    POINT du, dv;
    evaluate(points, uv, 1.0 - uv, point, du, dv);
    vec3 crossed = cross(tangent(point, dv), tangent(point, du));
#endif
    vec3 normal = mat3(MATRIX(normalToView, 8)) * crossed;
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
