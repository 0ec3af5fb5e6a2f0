// Report, section 2.3: evaluates a patch of degree 4 by Bernstein polynomials. Keep in step with
// src/bezier.rs.

layout(quads, equal_spacing, ccw) in;

in TCS_OUT {
    vec4 position;
} tes_in[];

out TES_OUT {
    vec2 texCoord;
} tes_out;
#ifdef FAR_DEPTH
layout(location = 2) out vec4 position; // view space
#endif

layout(location = 1) uniform mat4 model;
layout(location = 2) uniform mat4 view;
layout(location = 3) uniform mat4 projection;
layout(location = 4) uniform vec3 part; // sub-patch in the domain: first u, first v, side length

float power(float t, int n)
{
    // A product, because pow(0, 0) is undefined.
    float p = 1.0;
    for (int i = 0; i < n; ++i)
        p *= t;
    return p;
}

float bernstein(int i, int n, float t)
{
    float coeff = 1.0;
    for (int j = 1; j <= i; ++j)
        coeff *= float(n - j + 1) / float(j);
    return coeff * power(t, i) * power(1.0 - t, n - i);
}

vec4 bezierSurface(float u, float v)
{
    vec4 result = vec4(0.0);
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            result += bernstein(i, 4, v) * bernstein(j, 4, u) * tes_in[i * 5 + j].position;
    return result;
}

void main()
{
    float u = part.x + part.z * gl_TessCoord.x;
    float v = part.y + part.z * gl_TessCoord.y;
    vec4 viewPoint = view * (model * bezierSurface(u, v));
    gl_Position = projection * viewPoint;
#ifdef FAR_DEPTH
    position = viewPoint / viewPoint.w;
#endif
    tes_out.texCoord = clamp(vec2(u, v), 0.0, 1.0);
}
