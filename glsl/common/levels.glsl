// The positions of vertices along an edge, which come out equal on both sides of the edge. All sums
// and products in `along` are integers, or integers plus one half, below 2¹⁴. They are therefore
// exact.

// The quotient of two integers, correctly rounded also on drivers whose division is not. So 1/2 and
// 2/4 are equal bit for bit. `reciprocal` is 1 / b.
float ratio(float a, float b, float reciprocal)
{
    precise float quotient = a / b;
    precise float rest = fma(-quotient, b, a);
    precise float corrected = quotient + rest * reciprocal;
    return corrected;
}

// The parameters t and 1 - t of a vertex along one direction of the patch. `tessCoord` is its
// coordinate in the sub-patch, which has `cells` cells in this direction. The vertex moves to a
// multiple of 1 / `levels` of the sub-patch.
vec2 along(float tessCoord, float cells, float levels, float subPatch, float subPatches)
{
    float i = round(tessCoord * cells), fromEnd = cells - i;
    // Rounded up; the half absorbs the error of the division. Vertices of one half are limited to
    // that half, because otherwise their order would be reversed at the middle.
    float level = min(floor((min(i, fromEnd) * levels + (cells - 0.5)) / cells), floor(0.5 * levels));
    level = i < fromEnd ? level : i > fromEnd ? levels - level : ceil(0.5 * levels);
    float at = subPatch * levels + level, all = subPatches * levels, reciprocal = 1.0 / all;
    return vec2(ratio(at, all, reciprocal), ratio(all - at, all, reciprocal));
}
