// The control points of a patch.
//
// With DEGENERATE patches may be rational, and their normals may vanish; else all weights are 1.

layout(binding = 3) uniform samplerBuffer controlPoints; // homogeneous, centred and scaled

#ifdef DEGENERATE
#define POINT vec4
#else
#define POINT vec3
#endif

// The control points of the patch whose first this is, with their weights if those may differ from 1.
void fetchPatch(int first, out POINT points[SIDE * SIDE])
{
    for (int i = 0; i < SIDE * SIDE; ++i) {
        vec4 point = texelFetch(controlPoints, first + i);
#ifdef DEGENERATE
        points[i] = point;
#else
        points[i] = point.xyz;
#endif
    }
}
