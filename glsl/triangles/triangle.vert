// Hands on a corner of a triangle.

layout(location = 0) in vec4 corner;   // centred and scaled; s of the texture coordinates
layout(location = 1) in vec4 normal;   // of unit length or zero; t of the texture coordinates
layout(location = 2) in vec3 leaving;  // the normal here that shapes the edge to the next corner
layout(location = 3) in vec3 arriving; // and the edge from the corner before

out vec4 normalOfCorner;
out vec3 leavingCorner;
out vec3 arrivingCorner;

void main()
{
    gl_Position = corner;
    normalOfCorner = normal;
    leavingCorner = leaving;
    arrivingCorner = arriving;
}
