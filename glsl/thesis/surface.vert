// Hands the control points on to the tessellation stages.

layout(location = 0) in vec4 controlPoint; // homogeneous: (x·w, y·w, z·w, w)

void main()
{
    gl_Position = controlPoint;
}
