// Passes the control points on to the tessellation stages.

layout(location = 0) in vec4 controlPoint; // homogeneous: (x·w, y·w, z·w, w)

#ifdef AOV
// The number of the patch. gl_PrimitiveID cannot be used, because it restarts where a driver
// divides a draw (docs/drivers.md).
layout(location = 25) uniform int firstPatch; // number of the first patch in the scene
layout(location = 31) uniform int firstPoint; // index of its first control point in the buffer
flat out uint patchOfPoint;
#endif

void main()
{
    gl_Position = controlPoint;
#ifdef AOV
    patchOfPoint = uint(firstPatch + (gl_VertexID - firstPoint) / (SIDE * SIDE));
#endif
}
