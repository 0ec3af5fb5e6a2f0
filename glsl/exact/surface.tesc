// Sets the number of cells of a sub-patch, and fetches the control points of its patch, once for
// all vertices if HELD is defined. A patch has COLUMNS × ROWS control points.

layout(vertices = 1) out;

flat in uvec4 placeOfVertex[];
flat in uvec4 cutOfVertex[];

patch out uvec4 placeOfPatch;
patch out uvec4 cutOfPatch;
#ifdef HELD
patch out PATCH pointsOfPatch;
#endif
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
#ifdef ANY_DEGREE
    COLUMNS = int(cut.y >> 16 & 0xffu);
    ROWS = int(cut.y >> 24);
#endif
#if defined(HELD) || defined(DEGENERATE)
    PATCH points;
    fetchPatch(int(placeOfVertex[0].x), points);
#endif
#ifdef HELD
    pointsOfPatch = points;
#endif
#ifdef DEGENERATE
    longest = vec2(0.0);
    for (int row = 0; row < ROWS; ++row)
        for (int column = 0; column < COLUMNS; ++column) {
            int i = row * COLUMNS + column;
            if (column + 1 < COLUMNS)
                longest.x = max(longest.x, apart(pointOf(points, i), pointOf(points, i + 1)));
            if (row + 1 < ROWS)
                longest.y = max(longest.y, apart(pointOf(points, i), pointOf(points, i + COLUMNS)));
        }
    longest *= vec2(COLUMNS - 1, ROWS - 1);
#endif
    float along_u = float(cut.y & 0xffu), along_v = float(cut.y >> 8 & 0xffu);
    gl_TessLevelOuter[0] = gl_TessLevelOuter[2] = gl_TessLevelInner[1] = along_v;
    gl_TessLevelOuter[1] = gl_TessLevelOuter[3] = gl_TessLevelInner[0] = along_u;
}
