// The true surface at a pixel: its normal, or with CURVATURE its curvature (twin of src/bezier/curvature.rs).
//
// The triangle tells about where on the patch a pixel is: the point there is seen up to the tolerance beside the pixel.
// Curvature, and normals for draft, are evaluated again where a step of Newton's method leads. For stripes it is enough to
// know how normals change from pixel to pixel, which costs less.
//
// Control points are relative to one of the patch. So f32 resolves derivatives as well in a surface of many patches as in
// a single one (src/renderer/points.rs).

layout(location = 46) uniform int localPoints; // how far behind a control point it is relative to its patch

// The origin of the relative control points, of which `firstPoint` is the first.
vec3 originOf(POINT firstPoint)
{
    vec4 first = texelFetch(controlPoints, int(passPlace.x));
    return (first.xyz - firstPoint.xyz) / first.w;
}

#if defined(CURVATURE) || defined(DRAFT)
// Steps of Newton's method. One is enough for colours.
#ifdef CURVATURE_AOV
const int STEPS = 4;
#else
const int STEPS = 1;
#endif
// A step of more than this many times the lengths that it has at a right angle is not taken in full: near a silhouette,
// the surface is seen edge-on.
const float MOST = 4.0;

// The step from (u, v) to the place that is seen at the pixel. It may lead a little beyond the patch, where the
// neighbour continues it.
vec2 stepToPixel(Seen here)
{
    vec2 off = pixelPlace() - here.place, a = here.along[0], b = here.along[1];
    float area = a.x * b.y - a.y * b.x;
    vec2 numerators = vec2(off.x * b.y - off.y * b.x, a.x * off.y - a.y * off.x);
    float most = MOST * length(off) * abs(area);
    float longest = max(abs(numerators.x) * length(a), abs(numerators.y) * length(b));
    // As a product, because all of them may be 0.
    float size = max(longest, most) * abs(area);
    return here.isBefore && size > 0.0 && size < 1e37 ? numerators * (sign(area) * most / size) : vec2(0.0);
}

// The (u, v) of the patch that are seen at the pixel, from those of the triangle.
vec2 uvAtPixel(PATCH points, vec2 uv)
{
    vec3 origin = originOf(pointOf(points, 0));
    for (int i = 0; i < STEPS; ++i) {
        vec4 point;
        POINT du, dv;
        evaluate(points, uv, 1.0 - uv, point, du, dv);
        point.xyz += origin * point.w;
#ifdef RATIONAL
        du.xyz += origin * du.w;
        dv.xyz += origin * dv.w;
#endif
        // Further outside, a patch of high degree has nothing to do with its neighbour.
        uv = clamp(uv + stepToPixel(see(MATRIX(toClip, 0), point, du, dv)), -0.5, 1.5);
    }
    return uv;
}
#endif

#ifdef CURVATURE
// Curvatures beyond this are not told apart.
const float LARGEST = 1e30;

// The Gaussian curvature, the mean curvature and half of the difference of the principal curvatures at a pixel, in the
// world's unit, and the unit normal Su × Sv in view space. The mean is above 0 where the surface bends towards this normal.
vec3 curvatureAt(vec2 uv, out vec3 normal)
{
    PATCH points;
    fetchPatch(firstPointOfPixel() + localPoints, points);
    uv = uvAtPixel(points, uv);
    Curved at = evaluateCurved(points, uv);
#ifdef DEGENERATE
    // At a pole, where a tangent vanishes, the curvature is that of a place nearby.
    float square = 1.0 / (at.point.w * at.point.w);
    vec2 sizes = square * vec2(length(tangent(at.point, at.du)), length(tangent(at.point, at.dv)));
    if (any(lessThan(sizes, passLongest / 4096.0)))
        at = evaluateCurved(points, mix(uv, vec2(0.5), 1.0 / 1024.0));
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
    // Along u and at a right angle to it.
    m = (m - cosine * l) * inversesqrt(area);
    n = l + (n - l - 2.0 * cosine * m * sqrt(area)) / area;
    float mean = 0.5 * (l + n), apart = length(vec2(0.5 * (l - n), m));
    vec3 found = vec3((l * n - m * m) / unit, mean, apart) / unit;
    // Where tangents are parallel, it may be no number.
    return mix(clamp(found, -LARGEST, LARGEST), vec3(0.0), isnan(found));
}
#else
// The normal Sv × Su at a pixel, in view space, of about unit length. It has derivatives: not behind a discard.
vec3 normalAt(vec2 uv)
{
    PATCH points;
    fetchPatch(firstPointOfPixel() + localPoints, points);
#ifdef DRAFT
    uv = uvAtPixel(points, uv);
#endif
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
    normal = size > 0.0 && size < 1e37 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
#ifdef DRAFT
    return normal;
#else
    vec4 clip = MATRIX(toClip, 0) * (point + vec4(originOf(pointOf(points, 0)) * point.w, 0.0));
    // How many pixels it is to where the point is seen.
    vec2 off = pixelPlace() - viewport.zw * clip.xy / clip.w;
    off = clip.w > 0.0 && dot(off, off) < 1e9 ? clamp(off, -4.0, 4.0) : vec2(0.0);
    return normal + off.x * dFdxFine(normal) + off.y * dFdyFine(normal);
#endif
}
#endif
