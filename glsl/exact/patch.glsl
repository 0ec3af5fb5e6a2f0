// Evaluates a patch in Bernstein form, and its normal. Keep in step with src/bezier.rs.
//
// t is a parameter and s is 1 - t, each rounded separately. A neighbouring patch whose parameter
// runs in the opposite direction has the same two numbers exchanged. All sums and products of a
// point are ordered such that this exchange does not change a bit of the result.

#ifdef ANY_DEGREE
const int LONGEST = 16;
#else
const int LONGEST = max(COLUMNS, ROWS);
#endif

// Drivers unroll the loops here if the number of rounds is a constant, also of loops within loops, and if the
// condition compares the counter itself. Otherwise patches of low degree take up to three times as long.

// The binomial coefficient "n over i + 1", from "n over i".
int nextBinomial(int binomial, int n, int i)
{
    return binomial * (n - i) / (i + 1);
}

// Bernstein polynomials of degree n.
void bernstein(int n, float t, float s, out float b[LONGEST])
{
    float ofT[LONGEST], ofS[LONGEST]; // powers
    ofT[0] = ofS[0] = 1.0;
    ofT[1] = t;
    ofS[1] = s;
    for (int i = 2; i <= n; ++i) {
        precise float powerOfT = ofT[i / 2] * ofT[i - i / 2], powerOfS = ofS[i / 2] * ofS[i - i / 2];
        ofT[i] = powerOfT;
        ofS[i] = powerOfS;
    }
    for (int i = 0, binomial = 1; i <= n; ++i) {
        precise float value = float(binomial) * (ofS[n - i] * ofT[i]);
        b[i] = value;
        binomial = nextBinomial(binomial, n, i);
    }
}

// The same times a factor. Here the rounding may depend on the direction.
void bernsteinTimes(int factor, int n, float t, float s, out float b[LONGEST])
{
    for (int i = 0, binomial = 1; i <= n; ++i) {
        float value = float(factor * binomial);
        for (int j = 0; j < LONGEST - 1; ++j)
            value *= j < n - i ? s : 1.0;
        for (int j = 0; j < LONGEST - 1; ++j)
            value *= j < i ? t : 1.0;
        b[i] = value;
        binomial = nextBinomial(binomial, n, i);
    }
}

// Derivatives of the Bernstein polynomials of degree n.
void bernsteinSlopes(int n, float t, float s, out float slope[LONGEST])
{
    float lower[LONGEST];
    bernsteinTimes(n, n - 1, t, s, lower);
    slope[0] = -lower[0];
    for (int i = 1; i < n; ++i)
        slope[i] = lower[i - 1] - lower[i];
    slope[n] = lower[n - 1];
}

// The first n + 1 points times weights, from both ends towards the middle.
POINT weightedSum(int n, POINT p[LONGEST], float b[LONGEST])
{
    precise POINT sum = b[0] * p[0] + b[n] * p[n];
    for (int i = 1; i < (n + 1) / 2; ++i)
        sum += b[i] * p[i] + b[n - i] * p[n - i];
    if (n % 2 == 0)
        sum += b[n / 2] * p[n / 2];
    return sum;
}

// The same for a number that all points have in common.
float weightedSum(int n, float all, float b[LONGEST])
{
    precise float sum = b[0] * all + b[n] * all;
    for (int i = 1; i < (n + 1) / 2; ++i)
        sum += b[i] * all + b[n - i] * all;
    if (n % 2 == 0)
        sum += b[n / 2] * all;
    return sum;
}

// The homogeneous point and its derivatives along u and v.
void evaluate(PATCH points, vec2 t, vec2 s, out vec4 point, out POINT du, out POINT dv)
{
    float bu[LONGEST], bv[LONGEST], su[LONGEST], sv[LONGEST];
    bernstein(COLUMNS - 1, t.x, s.x, bu);
    bernstein(ROWS - 1, t.y, s.y, bv);
    bernsteinSlopes(COLUMNS - 1, t.x, s.x, su);
    bernsteinSlopes(ROWS - 1, t.y, s.y, sv);
    POINT rows[LONGEST];
    du = dv = POINT(0.0);
    for (int row = 0; row < ROWS; ++row) {
        POINT line[LONGEST];
        POINT slope = POINT(0.0);
        for (int column = 0; column < COLUMNS; ++column) {
            line[column] = pointOf(points, row * COLUMNS + column);
            slope += su[column] * line[column];
        }
        rows[row] = weightedSum(COLUMNS - 1, line, bu);
        du += bv[row] * slope;
        dv += sv[row] * rows[row];
    }
#ifdef RATIONAL
    point = weightedSum(ROWS - 1, rows, bv);
#else
    // The weight, 1, is rounded like that of a rational patch, so that patches of both kinds meet
    // bit for bit.
    point = vec4(weightedSum(ROWS - 1, rows, bv),
        weightedSum(ROWS - 1, weightedSum(COLUMNS - 1, 1.0, bu), bv));
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

#if defined(DEGENERATE) || defined(ANALYSIS) || defined(CURVATURE)
// Second derivatives of the Bernstein polynomials of degree n.
void bernsteinBends(int n, float t, float s, out float bend[LONGEST])
{
    float lowest[LONGEST];
    bernsteinTimes(n * (n - 1), n - 2, t, s, lowest);
    for (int i = 0; i <= n; ++i) {
        float before = i >= 2 ? lowest[max(i - 2, 0)] : 0.0;
        float here = i >= 1 && i < n ? lowest[clamp(i - 1, 0, max(n - 2, 0))] : 0.0;
        float after = i < n - 1 ? lowest[min(i, max(n - 2, 0))] : 0.0;
        bend[i] = n < 2 ? 0.0 : before - 2.0 * here + after;
    }
}

// A homogeneous point and its derivatives.
struct Curved {
    vec4 point;
    POINT du, dv, duu, duv, dvv;
};

Curved evaluateCurved(PATCH points, vec2 t)
{
    vec2 s = 1.0 - t;
    float bu[LONGEST], bv[LONGEST], su[LONGEST], sv[LONGEST], ru[LONGEST], rv[LONGEST];
    bernstein(COLUMNS - 1, t.x, s.x, bu);
    bernstein(ROWS - 1, t.y, s.y, bv);
    bernsteinSlopes(COLUMNS - 1, t.x, s.x, su);
    bernsteinSlopes(ROWS - 1, t.y, s.y, sv);
    bernsteinBends(COLUMNS - 1, t.x, s.x, ru);
    bernsteinBends(ROWS - 1, t.y, s.y, rv);
    Curved all;
    POINT point = POINT(0.0);
    all.du = all.dv = all.duu = all.duv = all.dvv = POINT(0.0);
    for (int row = 0; row < ROWS; ++row) {
        POINT value = POINT(0.0), slope = POINT(0.0), bend = POINT(0.0);
        for (int column = 0; column < COLUMNS; ++column) {
            POINT p = pointOf(points, row * COLUMNS + column);
            value += bu[column] * p;
            slope += su[column] * p;
            bend += ru[column] * p;
        }
        point += bv[row] * value;
        all.du += bv[row] * slope;
        all.dv += sv[row] * value;
        all.duu += bv[row] * bend;
        all.duv += sv[row] * slope;
        all.dvv += rv[row] * value;
    }
#ifdef RATIONAL
    all.point = point;
#else
    all.point = vec4(point, 1.0);
#endif
    return all;
}
#endif

#ifdef DEGENERATE
// The normal Sv × Su of a patch whose tangents may vanish or be parallel. There it is the first
// non-vanishing term of the normal's Taylor series along the diagonal into the patch; the quadratic
// term omits derivatives above the second. Not of unit length; zero if all terms vanish.
vec3 normalOf(Curved at, vec2 t, vec2 longest)
{
    float square = 1.0 / (at.point.w * at.point.w);
    vec3 u = square * tangent(at.point, at.du), v = square * tangent(at.point, at.dv);
    vec3 twist = square * tangent(at.point, at.duv);
    vec3 turn = square * (at.du.xyz * at.dv.w - at.dv.xyz * at.du.w);
    vec2 inwards = vec2(t.x < 0.5 ? 1.0 : -1.0, t.y < 0.5 ? 1.0 : -1.0);
    vec3 uInwards = inwards.x * square * tangent(at.point, at.duu) + inwards.y * (twist + turn);
    vec3 vInwards = inwards.x * (twist - turn) + inwards.y * square * tangent(at.point, at.dvv);

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
