// A patch by Bernstein polynomials, with the true normal. Keep in step with src/bezier.rs.

layout(quads, equal_spacing, ccw) in;

layout(location = 1) uniform mat4 modelMatrix;
layout(location = 2) uniform mat4 viewMatrix;
layout(location = 3) uniform mat4 projectionMatrix;

patch in vec4 partOfPatch; // least and greatest (u, v)

invariant gl_Position;  // parts of a patch are drawn by two programs and must meet
out vec3 passNormal;    // view space, unit length
out vec2 passTessCoord; // (u, v), for the trims and the texture
out vec4 position;      // view space

// Bernstein polynomials of degree SIDE - 1 at t, and their derivatives.
void bernstein(float t, out float b[SIDE], out float slope[SIDE])
{
    float s = 1.0 - t;
#if SIDE == 4
    b = float[](s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t);
    float lower[] = float[](s * s, 2.0 * s * t, t * t);
#else
    float s2 = s * s, t2 = t * t;
    b = float[](s2 * s2, 4.0 * s2 * s * t, 6.0 * s2 * t2, 4.0 * s * t * t2, t2 * t2);
    float lower[] = float[](s2 * s, 3.0 * s2 * t, 3.0 * s * t2, t2 * t);
#endif
    for (int i = 0; i < SIDE; ++i) {
        float before = i > 0 ? lower[max(i - 1, 0)] : 0.0;
        float after = i < SIDE - 1 ? lower[min(i, SIDE - 2)] : 0.0;
        slope[i] = float(SIDE - 1) * (before - after);
    }
}

// The homogeneous point and its derivatives along u and v.
void evaluate(vec2 uv, out vec4 point, out vec4 du, out vec4 dv)
{
    float bu[SIDE], su[SIDE], bv[SIDE], sv[SIDE];
    bernstein(uv.x, bu, su);
    bernstein(uv.y, bv, sv);
    point = du = dv = vec4(0.0);
    for (int row = 0; row < SIDE; ++row) {
        vec4 along = vec4(0.0), slope = vec4(0.0);
        for (int column = 0; column < SIDE; ++column) {
            vec4 controlPoint = gl_in[row * SIDE + column].gl_Position;
            along += bu[column] * controlPoint;
            slope += su[column] * controlPoint;
        }
        point += bv[row] * along;
        du += bv[row] * slope;
        dv += sv[row] * along;
    }
}

// The normal, crossed v first as in the thesis; zero where the tangents give none: where one is as
// short as rounding beside the other. The quotient rule's denominator shortens both alike.
vec3 normal(vec4 point, vec4 du, vec4 dv)
{
    mat3 toView = mat3(viewMatrix) * mat3(modelMatrix);
    vec3 tangentU = toView * (du.xyz * point.w - point.xyz * du.w);
    vec3 tangentV = toView * (dv.xyz * point.w - point.xyz * dv.w);
    vec3 crossed = cross(tangentV, tangentU);
    float size = length(crossed);
    float longest = max(dot(tangentU, tangentU), dot(tangentV, tangentV));
    return size > 1e-5 * longest ? crossed / size : vec3(0.0);
}

void main()
{
    // So that parts meet bit for bit: exact at 0 and at 1.
    precise vec2 uv = partOfPatch.xy * (1.0 - gl_TessCoord.xy) + partOfPatch.zw * gl_TessCoord.xy;
    vec4 point, du, dv;
    evaluate(uv, point, du, dv);
    passNormal = normal(point, du, dv);
    if (passNormal == vec3(0.0)) {
        // At a pole, as in the teapot's lid: the normal a little nearer the middle of the patch.
        vec4 near, nearDu, nearDv;
        evaluate(mix(uv, vec2(0.5), 1.0 / 1024.0), near, nearDu, nearDv);
        passNormal = normal(near, nearDu, nearDv);
    }
    passTessCoord = uv;
    vec4 viewPoint = viewMatrix * (modelMatrix * point);
    position = viewPoint / viewPoint.w;
    gl_Position = projectionMatrix * viewPoint;
}
