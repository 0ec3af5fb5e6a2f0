// Hands a control point and the part of the domain that this instance draws on.

layout(location = 0) in vec4 controlPoint; // homogeneous: (x·w, y·w, z·w, w)
layout(location = 1) in vec4 part;         // least and greatest (u, v); one for each instance

out vec4 partOfVertex;

void main()
{
    gl_Position = controlPoint;
    partOfVertex = part;
}
