// Passes on a corner of a triangle and the triangle's number: corner i of the buffer belongs to
// triangle i / 3. gl_PrimitiveID cannot be used, because it restarts where a driver divides a draw
// (docs/drivers.md).

layout(location = 0) in vec4 corner;   // centred and scaled; w is texture coordinate s
layout(location = 1) in vec4 normal;   // of unit length or zero; w is texture coordinate t
// The normals at this corner that shape two edges; flat triangles have neither.
layout(location = 2) in vec3 leaving;  // for the edge to the next corner
layout(location = 3) in vec3 arriving; // for the edge from the previous corner

#ifdef COLORED
layout(location = 4) in vec3 color;

out vec3 colorOfCorner;
#endif
out vec4 normalOfCorner;
out vec3 leavingCorner;
out vec3 arrivingCorner;
flat out uint triangleOfCorner; // in its mesh

void main()
{
    gl_Position = corner;
    normalOfCorner = normal;
    leavingCorner = leaving;
    arrivingCorner = arriving;
#ifdef COLORED
    colorOfCorner = color;
#endif
    triangleOfCorner = uint(gl_VertexID / 3);
}
