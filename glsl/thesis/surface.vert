// Hands the control points on to the tessellation stages.

layout(location = 0) in vec4 controlPoint; // homogeneous: (x·w, y·w, z·w, w)

#ifdef AOV
// The patch's number. gl_PrimitiveID would not do: drivers that divide a draw begin it anew (docs/drivers.md).
layout(location = 25) uniform int firstPatch; // of the draw, among all of the scene
layout(location = 31) uniform int firstPoint; // of the draw, in its buffer
flat out uint patchOfPoint;
#endif

void main()
{
    gl_Position = controlPoint;
#ifdef AOV
    patchOfPoint = uint(firstPatch + (gl_VertexID - firstPoint) / (SIDE * SIDE));
#endif
}
