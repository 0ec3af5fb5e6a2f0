// The corners of the rectangle that contains a segment of a stroke: two triangles a segment.
//
// Each instance is a group of segments.

layout(binding = 8) uniform samplerBuffer strokes; // for each segment, 10 texels: src/tessellation/strokes/segment.rs

layout(location = 26) uniform vec4 viewport;    // first pixel, half of width and height
layout(location = 35) uniform int groupSize;    // segments of an instance
layout(location = 37) uniform int segments;     // number behind the last segment
layout(location = 41) uniform int firstSegment;

layout(location = 0) flat out int segment;
layout(location = 1) noperspective out vec2 place; // pixels from the middle of the viewport

void main()
{
    segment = firstSegment + gl_VertexID / 6 + gl_InstanceID * groupSize;
    if (segment >= segments) {
        place = vec2(0.0);
        gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
        return;
    }
    int corner = int(0xda4u >> uint(2 * (gl_VertexID % 6)) & 3u);
    vec4 ends = texelFetch(strokes, 10 * segment);
    float halfWidth = abs(texelFetch(strokes, 10 * segment + 1).z);
    vec2 sag = texelFetch(strokes, 10 * segment + 2).xy;
    vec2 line = ends.zw - ends.xy;
    float size = length(line);
    vec2 along = size > 0.0 ? line / size : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    bool atEnd = (corner & 1) != 0, above = (corner & 2) != 0;
    place = (atEnd ? ends.zw : ends.xy) + halfWidth * (atEnd ? along : -along);
    float bulge = dot(sag, across);
    place += across * (above ? halfWidth + max(bulge, 0.0) : min(bulge, 0.0) - halfWidth);
    gl_Position = vec4(place / viewport.zw, 0.0, 1.0);
}
