// Cuts a part of a patch into cells. SIDE is 4 or 5: control points along a side.

layout(vertices = 1) out;

flat in uvec4 placeOfVertex[];
flat in uvec4 cutOfVertex[];

patch out uvec4 placeOfPatch;
patch out uvec4 cutOfPatch;
#ifdef DEGENERATE
layout(binding = 3) uniform samplerBuffer controlPoints; // homogeneous, centred and scaled

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
    uvec4 cut = cutOfVertex[0];
    placeOfPatch = placeOfVertex[0];
    cutOfPatch = cut;
#ifdef DEGENERATE
    int first = int(placeOfVertex[0].x);
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
