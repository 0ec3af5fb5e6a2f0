// Report, section 2.2: 25 control points, and the same level for every edge and the inside.

layout(vertices = 25) out;

out TCS_OUT {
    vec4 position; // homogeneous
} tcs_out[];

layout(location = 0) uniform float tessLevel;

void main()
{
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    tcs_out[gl_InvocationID].position = gl_in[gl_InvocationID].gl_Position;
    if (gl_InvocationID == 0) {
        for (int edge = 0; edge < 4; ++edge)
            gl_TessLevelOuter[edge] = tessLevel;
        gl_TessLevelInner[0] = tessLevel;
        gl_TessLevelInner[1] = tessLevel;
    }
}
