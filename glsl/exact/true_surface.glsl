// The true surface at a pixel: its normal, or with CURVATURE its curvature (twin of src/bezier/curvature.rs).
//
// The triangle tells about where on the patch a pixel is: the point there is seen up to the tolerance beside the pixel.
// How (u, v) and normals change from pixel to pixel tells what they are at the pixel itself. The functions here have
// derivatives: not behind a discard.
//
// Control points are relative to the first one of the patch. So f32 resolves derivatives as well in a surface of many
// patches as in a single one.

layout(location = 46) uniform int localPoints; // how far behind a control point it is relative to its patch

// How many pixels to go from where a point is seen to the pixel.
vec2 stepToPixel(vec4 localPoint)
{
    vec4 first = texelFetch(controlPoints, int(passPlace.x));
    vec4 point = localPoint + vec4(first.xyz * (localPoint.w / first.w), 0.0);
    vec4 clip = MATRIX(toClip, 0) * point;
    vec2 step = pixelPlace() - viewport.zw * clip.xy / clip.w;
    return clip.w > 0.0 ? clamp(step, -1.0, 1.0) : vec2(0.0);
}

vec2 atPixel(vec2 value, vec2 step)
{
    return value + step.x * dFdxFine(value) + step.y * dFdyFine(value);
}

vec3 atPixel(vec3 value, vec2 step)
{
    return value + step.x * dFdxFine(value) + step.y * dFdyFine(value);
}

#ifdef CURVATURE
// Curvatures beyond this are not told apart.
const float LARGEST = 1e30;

// The Gaussian and the mean curvature at a pixel, in the world's unit, and the unit normal Su × Sv in view space. The
// mean is above 0 where the surface bends towards this normal.
vec2 curvatureAt(vec2 uv, out vec3 normal)
{
    PATCH points;
    fetchPatch(firstPointOfPixel() + localPoints, points);
    vec4 point;
    POINT du, dv;
    evaluate(points, uv, 1.0 - uv, point, du, dv);
    uv = atPixel(uv, stepToPixel(point));
    Curved at = evaluateCurved(points, uv);
#ifdef DEGENERATE
    // At a pole, where a tangent vanishes, the curvature is that of a place nearby.
    float square = 1.0 / (at.point.w * at.point.w);
    vec2 sizes = square * vec2(length(tangent(at.point, at.du)), length(tangent(at.point, at.dv)));
    if (any(lessThan(sizes, passLongest / 256.0)))
        at = evaluateCurved(points, mix(uv, vec2(0.5), 1.0 / 128.0));
#endif
    mat3 toSpace = mat3(MATRIX(toView, 4));
    vec3 columns = max(abs(toSpace[0]), max(abs(toSpace[1]), abs(toSpace[2])));
    float unit = max(columns.x, max(columns.y, columns.z));
    toSpace /= unit;
    // What is left out of the quotient rule's terms lies in the tangent plane.
    float w = 1.0 / (at.point.w * at.point.w);
    vec3 u = toSpace * (w * tangent(at.point, at.du)), v = toSpace * (w * tangent(at.point, at.dv));
    vec3 uu = toSpace * (w * tangent(at.point, at.duu)), twist = toSpace * (w * tangent(at.point, at.duv)),
         vv = toSpace * (w * tangent(at.point, at.dvv));
    // Along tangents of unit length.
    vec2 lengths = max(vec2(length(u), length(v)), 1e-18);
    u /= lengths.x;
    v /= lengths.y;
    vec3 crossed = cross(u, v);
    float area = max(dot(crossed, crossed), 1e-12), cosine = dot(u, v);
    normal = crossed * inversesqrt(area);
    float l = dot(uu, normal) / lengths.x / lengths.x, m = dot(twist, normal) / lengths.x / lengths.y,
          n = dot(vv, normal) / lengths.y / lengths.y;
    vec2 curvature = vec2((l * n - m * m) / area / unit, 0.5 * (l + n - 2.0 * cosine * m) / area) / unit;
    return clamp(curvature, -LARGEST, LARGEST);
}
#else
// The normal Sv × Su at a pixel, in view space, of about unit length.
vec3 normalAt(vec2 uv)
{
    PATCH points;
    fetchPatch(firstPointOfPixel() + localPoints, points);
#ifdef DEGENERATE
    Curved at = evaluateCurved(points, uv);
    vec4 point = at.point;
    vec3 crossed = normalOf(at, uv, passLongest);
#else
    vec4 point;
    POINT du, dv;
    evaluate(points, uv, 1.0 - uv, point, du, dv);
    vec3 crossed = cross(tangent(point, dv), tangent(point, du));
#endif
    vec3 normal = mat3(MATRIX(normalToView, 8)) * crossed;
    float size = dot(normal, normal);
    normal = size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
    return atPixel(normal, stepToPixel(point));
}
#endif
