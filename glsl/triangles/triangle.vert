// Hands on a corner of a triangle, with the triangle's number: corner i of the buffer belongs to triangle
// i / 3. gl_PrimitiveID would not do: drivers that divide a draw begin it anew (docs/drivers.md).

layout(location = 0) in vec4 corner;   // centred and scaled; s of the texture coordinates
layout(location = 1) in vec4 normal;   // of unit length or zero; t of the texture coordinates
// Of flat triangles without these:
layout(location = 2) in vec3 leaving;  // the normal here that shapes the edge to the next corner
layout(location = 3) in vec3 arriving; // and the edge from the corner before

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
