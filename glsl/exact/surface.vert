// Fetches the description of a sub-patch, which is the only vertex of an OpenGL patch. The control
// stage fetches the control points.
//
// Each instance of a draw is a group of sub-patches.

// For each sub-patch two texels. The first: first control point, patch, surface, column | row << 16.
// The second is packed: levels of the edges; cells along u and v, columns and rows of the patch;
// sub-patches of the patch along u and v; trims.
layout(binding = 8) uniform usamplerBuffer subPatches;

layout(location = 35) uniform int groupSize; // sub-patches of an instance, if there are several

flat out uvec4 placeOfVertex;
flat out uvec4 cutOfVertex;

void main()
{
    int texel = 2 * (gl_VertexID + gl_InstanceID * groupSize);
    placeOfVertex = texelFetch(subPatches, texel);
    cutOfVertex = texelFetch(subPatches, texel + 1);
}
