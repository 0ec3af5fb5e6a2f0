// Evaluates a patch in Bernstein form, and its normal. Keep in step with src/bezier.rs.
//
// t is a parameter and s is 1 - t, each rounded separately. A neighbouring patch whose parameter
// runs in the opposite direction has the same two numbers exchanged. All sums and products of a
// point are ordered such that this exchange does not change a bit of the result.

// Bernstein polynomials of degree SIDE - 1.
void bernstein(float t, float s, out float b[SIDE])
{
    precise float s2 = s * s, t2 = t * t;
#if SIDE == 4
    precise float b1 = 3.0 * (s2 * t), b2 = 3.0 * (t2 * s), b0 = s2 * s, b3 = t2 * t;
    b = float[](b0, b1, b2, b3);
#else
    precise float b1 = 4.0 * ((s2 * s) * t), b3 = 4.0 * ((t2 * t) * s);
    precise float b0 = s2 * s2, b2 = 6.0 * (s2 * t2), b4 = t2 * t2;
    b = float[](b0, b1, b2, b3, b4);
#endif
}

// The first derivatives of the Bernstein polynomials.
void bernsteinSlopes(float t, float s, out float slope[SIDE])
{
#if SIDE == 4
    float lower[] = float[](3.0 * s * s, 6.0 * s * t, 3.0 * t * t);
#else
    float lower[] = float[](4.0 * s * s * s, 12.0 * s * s * t, 12.0 * s * t * t, 4.0 * t * t * t);
#endif
    slope[0] = -lower[0];
    for (int i = 1; i < SIDE - 1; ++i)
        slope[i] = lower[i - 1] - lower[i];
    slope[SIDE - 1] = lower[SIDE - 2];
}

// The sum of points times Bernstein polynomials. Symmetric: reversing both arrays changes no bit.
POINT weightedSum(POINT p[SIDE], float b[SIDE])
{
#if SIDE == 4
    precise POINT sum = (b[0] * p[0] + b[3] * p[3]) + (b[1] * p[1] + b[2] * p[2]);
#else
    precise POINT sum = ((b[0] * p[0] + b[4] * p[4]) + (b[1] * p[1] + b[3] * p[3])) + b[2] * p[2];
#endif
    return sum;
}

// The same sum if all points are the one number `all`.
float weightedSum(float all, float b[SIDE])
{
#if SIDE == 4
    precise float sum = (b[0] * all + b[3] * all) + (b[1] * all + b[2] * all);
#else
    precise float sum = ((b[0] * all + b[4] * all) + (b[1] * all + b[3] * all)) + b[2] * all;
#endif
    return sum;
}

// The homogeneous point and its derivatives along u and v.
void evaluate(POINT points[SIDE * SIDE], vec2 t, vec2 s, out vec4 point, out POINT du, out POINT dv)
{
    float bu[SIDE], bv[SIDE], su[SIDE], sv[SIDE];
    bernstein(t.x, s.x, bu);
    bernstein(t.y, s.y, bv);
    bernsteinSlopes(t.x, s.x, su);
    bernsteinSlopes(t.y, s.y, sv);
    POINT rows[SIDE];
    du = dv = POINT(0.0);
    for (int row = 0; row < SIDE; ++row) {
        POINT line[SIDE];
        POINT slope = POINT(0.0);
        for (int column = 0; column < SIDE; ++column) {
            line[column] = points[row * SIDE + column];
            slope += su[column] * line[column];
        }
        rows[row] = weightedSum(line, bu);
        du += bv[row] * slope;
        dv += sv[row] * rows[row];
    }
#ifdef RATIONAL
    point = weightedSum(rows, bv);
#else
    // The weight, 1, is rounded like that of a rational patch, so that patches of both kinds meet
    // bit for bit.
    point = vec4(weightedSum(rows, bv), weightedSum(weightedSum(1.0, bu), bv));
#endif
}

// The tangent by the quotient rule, without the division by the squared weight.
vec3 tangent(vec4 point, POINT derivative)
{
#ifdef RATIONAL
    return derivative.xyz * point.w - point.xyz * derivative.w;
#else
    return derivative;
#endif
}

#ifdef DEGENERATE
// The second derivatives of the Bernstein polynomials.
void bernsteinBends(float t, float s, out float bend[SIDE])
{
#if SIDE == 4
    float lowest[] = float[](6.0 * s, 6.0 * t);
#else
    float lowest[] = float[](12.0 * s * s, 24.0 * s * t, 12.0 * t * t);
#endif
    for (int i = 0; i < SIDE; ++i) {
        float before = i >= 2 ? lowest[max(i - 2, 0)] : 0.0;
        float here = i >= 1 && i < SIDE - 1 ? lowest[clamp(i - 1, 0, SIDE - 3)] : 0.0;
        float after = i < SIDE - 2 ? lowest[min(i, SIDE - 3)] : 0.0;
        bend[i] = before - 2.0 * here + after;
    }
}

// The normal Sv × Su of a patch whose tangents may vanish or be parallel. There it is the first
// non-vanishing term of the normal's Taylor series along the diagonal into the patch; the quadratic
// term omits derivatives above the second. Not of unit length; zero if all terms vanish.
vec3 patchNormal(POINT points[SIDE * SIDE], vec2 t, vec2 s, vec4 point, vec4 du, vec4 dv, vec2 longest)
{
    float bu[SIDE], bv[SIDE], su[SIDE], sv[SIDE], ru[SIDE], rv[SIDE];
    bernstein(t.x, s.x, bu);
    bernstein(t.y, s.y, bv);
    bernsteinSlopes(t.x, s.x, su);
    bernsteinSlopes(t.y, s.y, sv);
    bernsteinBends(t.x, s.x, ru);
    bernsteinBends(t.y, s.y, rv);
    vec4 duu = vec4(0.0), duv = vec4(0.0), dvv = vec4(0.0);
    for (int row = 0; row < SIDE; ++row) {
        for (int column = 0; column < SIDE; ++column) {
            vec4 p = points[row * SIDE + column];
            duu += ru[column] * bv[row] * p;
            duv += su[column] * sv[row] * p;
            dvv += bu[column] * rv[row] * p;
        }
    }
    float square = 1.0 / (point.w * point.w);
    vec3 u = square * tangent(point, du), v = square * tangent(point, dv);
    vec3 twist = square * tangent(point, duv);
    vec3 turn = square * (du.xyz * dv.w - dv.xyz * du.w);
    vec2 inwards = vec2(t.x < 0.5 ? 1.0 : -1.0, t.y < 0.5 ? 1.0 : -1.0);
    vec3 uInwards = inwards.x * square * tangent(point, duu) + inwards.y * (twist + turn);
    vec3 vInwards = inwards.x * (twist - turn) + inwards.y * square * tangent(point, dvv);

    vec3 normal = cross(v, u);
    float uu = dot(u, u), vv = dot(v, v);
    // Shorter tangents consist mostly of rounding errors.
    bool plain = uu > 1e-7 * longest.x * longest.x && vv > 1e-7 * longest.y * longest.y
        && dot(normal, normal) > 1e-8 * uu * vv;
    if (!plain) {
        float size = longest.x * longest.y;
        vec3 here = normal;
        normal = cross(v, uInwards) + cross(vInwards, u);
        if (dot(normal, normal) <= 1e-8 * size * size)
            normal = cross(vInwards, uInwards);
        // Near the point where the normal vanishes, the term may have the opposite sign. The normal
        // itself gives the sign, if it is larger than rounding errors.
        if (dot(here, here) > 1e-10 * size * size && dot(here, normal) < 0.0)
            normal = -normal;
    }
    return normal;
}
#endif
