// Report, section 3.2: draws the control points as squares.

layout(location = 0) in vec4 controlPoint; // homogeneous: (x·w, y·w, z·w, w)

out TES_OUT {
    vec2 texCoord;
} vs_out;

layout(location = 1) uniform mat4 model;
layout(location = 2) uniform mat4 view;
layout(location = 3) uniform mat4 projection;
layout(location = 23) uniform float pointSize; // width in pixels

void main()
{
    gl_Position = projection * (view * (model * controlPoint));
    gl_PointSize = pointSize;
    vs_out.texCoord = vec2(0.0);
}
