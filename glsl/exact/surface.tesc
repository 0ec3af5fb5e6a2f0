// Fetches the control points of a patch and the matrices of its surface, and cuts a part of it into
// cells. SIDE is 4 or 5: control points along a side.

layout(vertices = SIDE * SIDE) out;

layout(binding = 3) uniform samplerBuffer controlPoints; // homogeneous, centred and scaled
layout(binding = 4) uniform samplerBuffer surfaces;      // 12 columns of matrices for each

flat in uvec4 placeOfVertex[];
flat in uvec4 cutOfVertex[];

patch out uvec4 placeOfPatch;
patch out uvec4 cutOfPatch;
patch out mat4 toClip;
patch out mat4 toView;
patch out mat3 normalToView;
#ifdef DEGENERATE
patch out vec2 longest; // tangents along u and v, at most

// The difference between two control points.
float apart(int first, int i, int j)
{
    vec4 a = texelFetch(controlPoints, first + i), b = texelFetch(controlPoints, first + j);
    return distance(a.xyz / a.w, b.xyz / b.w);
}
#endif

void main()
{
    uvec4 place = placeOfVertex[0];
    int first = int(place.x);
    gl_out[gl_InvocationID].gl_Position = texelFetch(controlPoints, first + gl_InvocationID);
    if (gl_InvocationID == 0) {
        uvec4 cut = cutOfVertex[0];
        placeOfPatch = place;
        cutOfPatch = cut;
        int matrices = int(place.z) * 12;
        for (int column = 0; column < 4; ++column) {
            toClip[column] = texelFetch(surfaces, matrices + column);
            toView[column] = texelFetch(surfaces, matrices + 4 + column);
        }
        for (int column = 0; column < 3; ++column)
            normalToView[column] = texelFetch(surfaces, matrices + 8 + column).xyz;
#ifdef DEGENERATE
        longest = vec2(0.0);
        for (int line = 0; line < SIDE; ++line)
            for (int i = 0; i < SIDE - 1; ++i) {
                int u = line * SIDE + i, v = i * SIDE + line;
                longest = max(longest, vec2(apart(first, u, u + 1), apart(first, v, v + SIDE)));
            }
        longest *= float(SIDE - 1);
#endif
        float along_u = float(cut.y & 0xffu), along_v = float(cut.y >> 8);
        gl_TessLevelOuter[0] = gl_TessLevelOuter[2] = gl_TessLevelInner[1] = along_v;
        gl_TessLevelOuter[1] = gl_TessLevelOuter[3] = gl_TessLevelInner[0] = along_u;
    }
}
