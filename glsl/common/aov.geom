// Passes the data of all three vertices of a triangle to each of its fragments.

layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

layout(location = 0) in vec3 normalOfVertex[];
layout(location = 1) in vec2 tessCoordOfVertex[];
layout(location = 2) in vec4 positionOfVertex[];
layout(location = 3) flat in uint patchOfVertex[];

layout(location = 0) flat out vec3 cornerClips[3]; // x, y and w
layout(location = 3) flat out vec3 cornerNormals[3];
layout(location = 6) flat out vec3 cornerPositions[3];
layout(location = 9) flat out vec2 cornerTessCoords[3];
layout(location = 12) flat out uint patchOfTriangle;

#ifdef EVALUATED
layout(location = 4) flat in uvec4 placeOfVertex[];
layout(location = 13) flat out uvec4 passPlace;
#ifdef DEGENERATE
layout(location = 5) flat in vec2 longestOfVertex[];
layout(location = 14) flat out vec2 passLongest;
#endif
#endif

#if defined(LOOPS) || defined(SHAPES)
layout(location = 7) flat in uint trimsOfVertex[];
layout(location = 15) flat out uint passTrims;
#endif

void main()
{
    for (int vertex = 0; vertex < 3; ++vertex) {
        for (int i = 0; i < 3; ++i) {
            cornerClips[i] = gl_in[i].gl_Position.xyw;
            cornerNormals[i] = normalOfVertex[i];
            cornerPositions[i] = positionOfVertex[i].xyz;
            cornerTessCoords[i] = tessCoordOfVertex[i];
        }
        patchOfTriangle = patchOfVertex[0];
#ifdef EVALUATED
        passPlace = placeOfVertex[0];
#ifdef DEGENERATE
        passLongest = longestOfVertex[0];
#endif
#endif
#if defined(LOOPS) || defined(SHAPES)
        passTrims = trimsOfVertex[0];
#endif
        gl_Position = gl_in[vertex].gl_Position;
        EmitVertex();
    }
    EndPrimitive();
}
