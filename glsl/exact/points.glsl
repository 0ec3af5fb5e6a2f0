// The control points of a patch of COLUMNS × ROWS points. With ANY_DEGREE, these numbers are variables, and points are
// fetched one by one; without it, they are constants, and all points are fetched at once.
//
// With RATIONAL, weights may differ from 1; without it, all weights are 1 and are not fetched.

layout(binding = 3) uniform samplerBuffer controlPoints; // homogeneous, centred and scaled

#ifdef RATIONAL
#define POINT vec4
#else
#define POINT vec3
#endif

POINT fetchPoint(int index)
{
#ifdef RATIONAL
    return texelFetch(controlPoints, index);
#else
    return texelFetch(controlPoints, index).xyz;
#endif
}

#ifdef ANY_DEGREE
int COLUMNS, ROWS;

#define PATCH int // the index of the first point

void fetchPatch(int first, out PATCH points)
{
    points = first;
}

POINT pointOf(PATCH points, int i)
{
    return fetchPoint(points + i);
}
#else
#define PATCH POINT[COLUMNS * ROWS]
#define pointOf(points, i) points[i]

// The control points of the patch whose first point has the index `first`.
void fetchPatch(int first, out PATCH points)
{
    for (int i = 0; i < COLUMNS * ROWS; ++i)
        points[i] = fetchPoint(first + i);
}
#endif
