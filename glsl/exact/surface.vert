// Passes on the description of a sub-patch, which is the only vertex of an OpenGL patch. The
// control stage fetches the control points.

layout(location = 0) in uvec4 place; // first control point, patch, surface, column | row << 16
// Packed: levels of the edges; cells along u and v, columns and rows of the patch; sub-patches of the patch along u and v; trims.
layout(location = 1) in uvec4 cut;

flat out uvec4 placeOfVertex;
flat out uvec4 cutOfVertex;

void main()
{
    placeOfVertex = place;
    cutOfVertex = cut;
}
