// The control points of a patch.
//
// With RATIONAL, weights may differ from 1; without it, all weights are 1 and are not fetched.

layout(binding = 3) uniform samplerBuffer controlPoints; // homogeneous, centred and scaled

#ifdef RATIONAL
#define POINT vec4
#else
#define POINT vec3
#endif

// The control points of the patch whose first point has the index `first`.
void fetchPatch(int first, out POINT points[COLUMNS * ROWS])
{
    for (int i = 0; i < COLUMNS * ROWS; ++i) {
        vec4 point = texelFetch(controlPoints, first + i);
#ifdef RATIONAL
        points[i] = point;
#else
        points[i] = point.xyz;
#endif
    }
}
