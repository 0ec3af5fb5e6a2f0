// One level for every edge and the inside of a part. SIDE is 4 or 5: control points along a side.

layout(vertices = SIDE * SIDE) out;

layout(location = 0) uniform float tessLevel;

in vec4 partOfVertex[];
patch out vec4 partOfPatch; // least and greatest (u, v)

void main()
{
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    if (gl_InvocationID == 0) {
        partOfPatch = partOfVertex[0];
        for (int edge = 0; edge < 4; ++edge)
            gl_TessLevelOuter[edge] = tessLevel;
        gl_TessLevelInner[0] = tessLevel;
        gl_TessLevelInner[1] = tessLevel;
    }
}
