// Sets the number of cells of a sub-patch, and fetches the control points of its patch, once for
// all vertices. SIDE is 4 or 5, the number of control points along a side.

layout(vertices = 1) out;

flat in uvec4 placeOfVertex[];
flat in uvec4 cutOfVertex[];

patch out uvec4 placeOfPatch;
patch out uvec4 cutOfPatch;
patch out POINT pointsOfPatch[SIDE * SIDE];
#ifdef DEGENERATE
patch out vec2 longest; // estimated maximum lengths of the tangents along u and v

// The distance between two control points.
float apart(vec4 a, vec4 b)
{
    return distance(a.xyz / a.w, b.xyz / b.w);
}
#endif

void main()
{
    uvec4 cut = cutOfVertex[0];
    placeOfPatch = placeOfVertex[0];
    cutOfPatch = cut;
    POINT points[SIDE * SIDE];
    fetchPatch(int(placeOfVertex[0].x), points);
    pointsOfPatch = points;
#ifdef DEGENERATE
    longest = vec2(0.0);
    for (int line = 0; line < SIDE; ++line)
        for (int i = 0; i < SIDE - 1; ++i) {
            int u = line * SIDE + i, v = i * SIDE + line;
            longest = max(longest, vec2(apart(points[u], points[u + 1]), apart(points[v], points[v + SIDE])));
        }
    longest *= float(SIDE - 1);
#endif
    float along_u = float(cut.y & 0xffu), along_v = float(cut.y >> 8);
    gl_TessLevelOuter[0] = gl_TessLevelOuter[2] = gl_TessLevelInner[1] = along_v;
    gl_TessLevelOuter[1] = gl_TessLevelOuter[3] = gl_TessLevelInner[0] = along_u;
}
