// Listings 7 to 12: whether a point of the domain is cut. Keep in step with src/trim.rs (shapes)
// and src/thesis/newton.rs (loops).
//
// A switch of the thesis (…Bool) is 0 for off, or the number of trims of its kind. The first
// circle, interval (rectangle) and ellipse are in the uniforms of listing 13, all others in the
// buffer at binding 2. Only what a surface has is compiled in: CIRCLES, INTERVALS, ELLIPSES,
// MORE_SHAPES, QUADRATICS, NESTED_QUADRATICS, CUBICS, NESTED_CUBICS.

#ifdef CIRCLES
layout(location = 7) uniform float trimRadius;
layout(location = 8) uniform vec2 trimCenter;
layout(location = 12) uniform int circBool;

bool cutByCircle(vec2 uv, vec2 center, float radius)
{
    return distance(uv, center) < radius;
}
#endif

#ifdef INTERVALS
layout(location = 5) uniform vec2 trimValuesx; // first and last u
layout(location = 6) uniform vec2 trimValuesy; // first and last v
layout(location = 13) uniform int intervalBool;

bool cutByInterval(vec2 uv, vec2 x, vec2 y)
{
    return uv.x >= x.x && uv.x <= x.y && uv.y >= y.x && uv.y <= y.y;
}
#endif

#ifdef ELLIPSES
layout(location = 9) uniform float trimRadius1;
layout(location = 10) uniform float trimRadius2;
layout(location = 11) uniform vec2 trimEllipseCenter;
layout(location = 14) uniform int ellipseBool;

// Products, because the listing's pow(x, 2) is undefined for negative x.
bool cutByEllipse(vec2 uv, vec2 center, vec2 radii)
{
    vec2 d = uv - center;
    return radii.x > 0.0 && radii.y > 0.0
        && d.x * d.x / (radii.x * radii.x) + d.y * d.y / (radii.y * radii.y) <= 1.0;
}
#endif

#ifdef MORE_SHAPES
// Circles (center, radius), then intervals (u, v), then ellipses (center, radii).
layout(std430, binding = 2) readonly buffer trimShapesSsbo
{
    vec4 trimShapes_data[];
};
#endif

#if defined(QUADRATICS) || defined(NESTED_QUADRATICS) || defined(CUBICS) || defined(NESTED_CUBICS)
//      p1                p1    p2         `p` is the index of p0. If there is an inner loop, its
//    /    \            /          \       points follow those of the outer one in the same order.
//  p0      p2        p0            p3
//    \    /            \          /
//      p3                p4    p5
layout(std430, binding = 1) readonly buffer trimPointsSsbo
{
    vec2 trimPoints_data[];
};

layout(location = 19) uniform int newtonIterations; // the listing's 10
layout(location = 20) uniform float newtonEpsilon;  // the listing's 0.001

// The polynomial with Bernstein coefficients b at t, and its derivative: listings 8 and 9.
vec2 valueAndSlope(vec3 b, float t)
{
    float s = 1.0 - t;
    return vec2(s * s * b.x + 2.0 * t * s * b.y + t * t * b.z,
                2.0 * s * (b.y - b.x) + 2.0 * t * (b.z - b.y));
}

vec2 valueAndSlope(vec4 b, float t)
{
    float s = 1.0 - t;
    return vec2(s * s * s * b.x + 3.0 * t * s * s * b.y + 3.0 * t * t * s * b.z + t * t * t * b.w,
                3.0 * s * s * (b.y - b.x) + 6.0 * t * s * (b.z - b.y) + 3.0 * t * t * (b.w - b.z));
}

// Listing 10: Newton's method from t to a parameter at which the polynomial is v. Returns the last
// iterate, whether it has converged or not.
#define NEWTON(COEFFICIENTS)                                                                     \
    float root(COEFFICIENTS b, float v, float t)                                                 \
    {                                                                                            \
        for (int i = 0; i < newtonIterations; ++i) {                                             \
            vec2 f = valueAndSlope(b, t);                                                        \
            float h = (f.x - v) / f.y;                                                           \
            t -= h;                                                                              \
            if (abs(h) < newtonEpsilon)                                                          \
                break;                                                                           \
        }                                                                                        \
        return t;                                                                                \
    }                                                                                            \
                                                                                                 \
    /* Where the row of uv meets a curve, from t = 1 and t = 0: (t1, t2, x1, x2). */             \
    vec4 meetings(COEFFICIENTS x, COEFFICIENTS y, vec2 uv)                                       \
    {                                                                                            \
        float t1 = root(y, uv.y, 1.0);                                                           \
        float t2 = root(y, uv.y, 0.0);                                                           \
        return vec4(t1, t2, valueAndSlope(x, t1).x - uv.x, valueAndSlope(x, t2).x - uv.x);       \
    }

NEWTON(vec3)
NEWTON(vec4)

vec4 meetings(ivec3 p, vec2 uv)
{
    vec2 a = trimPoints_data[p.x], b = trimPoints_data[p.y], c = trimPoints_data[p.z];
    return meetings(vec3(a.x, b.x, c.x), vec3(a.y, b.y, c.y), uv);
}

vec4 meetings(ivec4 p, vec2 uv)
{
    vec2 a = trimPoints_data[p.x], b = trimPoints_data[p.y];
    vec2 c = trimPoints_data[p.z], d = trimPoints_data[p.w];
    return meetings(vec4(a.x, b.x, c.x, d.x), vec4(a.y, b.y, c.y, d.y), uv);
}

bool between(vec4 m)
{
    return m.z > 0.0 && m.w < 0.0;
}

bool onCurve(vec4 m)
{
    return m.x >= 0.0 && m.x <= 1.0 && m.y >= 0.0 && m.y <= 1.0;
}

// Listing 11, and the same for cubics.
bool newtonIterationTrimming(int p, vec2 uv)
{
    vec4 upper = meetings(p + ivec3(0, 1, 2), uv);
    vec4 lower = meetings(p + ivec3(0, 3, 2), uv);
    return (between(upper) && onCurve(upper)) || (between(lower) && onCurve(lower));
}

bool newtonIterationTrimmingCubic(int p, vec2 uv)
{
    vec4 upper = meetings(p + ivec4(0, 1, 2, 3), uv);
    vec4 lower = meetings(p + ivec4(0, 4, 5, 3), uv);
    return (between(upper) && onCurve(upper)) || (between(lower) && onCurve(lower));
}

// Listing 12, and the same for cubics. As in the listing, t of the inner curves is not checked to
// be in [0, 1].
bool newtonIterationTrimming2(int p, vec2 uv)
{
    vec4 upper = meetings(p + ivec3(0, 1, 2), uv);
    vec4 lower = meetings(p + ivec3(0, 3, 2), uv);
    vec4 innerUpper = meetings(p + ivec3(4, 5, 6), uv);
    vec4 innerLower = meetings(p + ivec3(4, 7, 6), uv);
    return (between(upper) && onCurve(upper) && !between(innerUpper))
        || (between(lower) && onCurve(lower) && !between(innerLower));
}

bool newtonIterationTrimmingCubic2(int p, vec2 uv)
{
    vec4 upper = meetings(p + ivec4(0, 1, 2, 3), uv);
    vec4 lower = meetings(p + ivec4(0, 4, 5, 3), uv);
    vec4 innerUpper = meetings(p + ivec4(6, 7, 8, 9), uv);
    vec4 innerLower = meetings(p + ivec4(6, 10, 11, 9), uv);
    return (between(upper) && onCurve(upper) && !between(innerUpper))
        || (between(lower) && onCurve(lower) && !between(innerLower));
}
#endif

#ifdef QUADRATICS
layout(location = 15) uniform int bezierBool;
#endif
#ifdef NESTED_QUADRATICS
layout(location = 16) uniform int bezierBool2;
#endif
#ifdef CUBICS
layout(location = 17) uniform int cubicBezierBool;
#endif
#ifdef NESTED_CUBICS
layout(location = 18) uniform int cubicBezierBool2;
#endif

// Whether any trim cuts uv.
bool cut(vec2 uv)
{
#ifdef MORE_SHAPES
    int shape = 0;
#endif
#ifdef CIRCLES
    if (circBool > 0 && cutByCircle(uv, trimCenter, trimRadius))
        return true;
#ifdef MORE_SHAPES
    for (int i = 1; i < circBool; ++i, ++shape)
        if (cutByCircle(uv, trimShapes_data[shape].xy, trimShapes_data[shape].z))
            return true;
#endif
#endif
#ifdef INTERVALS
    if (intervalBool > 0 && cutByInterval(uv, trimValuesx, trimValuesy))
        return true;
#ifdef MORE_SHAPES
    for (int i = 1; i < intervalBool; ++i, ++shape)
        if (cutByInterval(uv, trimShapes_data[shape].xy, trimShapes_data[shape].zw))
            return true;
#endif
#endif
#ifdef ELLIPSES
    if (ellipseBool > 0 && cutByEllipse(uv, trimEllipseCenter, vec2(trimRadius1, trimRadius2)))
        return true;
#ifdef MORE_SHAPES
    for (int i = 1; i < ellipseBool; ++i, ++shape)
        if (cutByEllipse(uv, trimShapes_data[shape].xy, trimShapes_data[shape].zw))
            return true;
#endif
#endif
    int p = 0;
#ifdef QUADRATICS
    for (int i = 0; i < bezierBool; ++i, p += 4)
        if (newtonIterationTrimming(p, uv))
            return true;
#endif
#ifdef NESTED_QUADRATICS
    for (int i = 0; i < bezierBool2; ++i, p += 8)
        if (newtonIterationTrimming2(p, uv))
            return true;
#endif
#ifdef CUBICS
    for (int i = 0; i < cubicBezierBool; ++i, p += 6)
        if (newtonIterationTrimmingCubic(p, uv))
            return true;
#endif
#ifdef NESTED_CUBICS
    for (int i = 0; i < cubicBezierBool2; ++i, p += 12)
        if (newtonIterationTrimmingCubic2(p, uv))
            return true;
#endif
    return false;
}
