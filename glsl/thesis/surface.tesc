// Listing 1: every edge and the inside of a patch get the same level.
//
//        outer[3]          SIDE is 4 or 5, the number of control points along a side.
//       +--------+
// outer |        | outer
//  [0]  | inner  |  [2]
//       +--------+
//        outer[1]

layout(vertices = SIDE * SIDE) out;

layout(location = 0) uniform float tessLevel;

#ifdef AOV
flat in uint patchOfPoint[];
patch out uint numberOfPatch;
#endif

void main()
{
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    if (gl_InvocationID == 0) {
        for (int edge = 0; edge < 4; ++edge)
            gl_TessLevelOuter[edge] = tessLevel;
        gl_TessLevelInner[0] = tessLevel;
        gl_TessLevelInner[1] = tessLevel;
#ifdef AOV
        numberOfPatch = patchOfPoint[0];
#endif
    }
}
