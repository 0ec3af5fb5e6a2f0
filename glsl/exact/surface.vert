// Hands on one sub-patch of a patch: the only vertex of what OpenGL takes for the patch. The control stage
// fetches its control points.

layout(location = 0) in uvec4 place; // first control point, patch, surface, column | row << 16
layout(location = 1) in uvec4 cut;   // levels of the edges, cells, sub-patches of the patch along u and v, unused

flat out uvec4 placeOfVertex;
flat out uvec4 cutOfVertex;

void main()
{
    placeOfVertex = place;
    cutOfVertex = cut;
}
