// Places along an edge, the same from both of its sides. All numbers here are whole and below 2¹⁴, so
// that sums and products of them are exact.

// One whole number over another: rounded correctly, also on drivers whose division is not, so that 1/2
// and 2/4 meet.
float ratio(float a, float b, float reciprocal)
{
    precise float quotient = a / b;
    precise float rest = fma(-quotient, b, a);
    precise float corrected = quotient + rest * reciprocal;
    return corrected;
}

// t and 1 - t along one direction: a whole number of levels over all of the patch's.
vec2 along(float tessCoord, float cells, float levels, float subPatch, float subPatches)
{
    float i = round(tessCoord * cells), fromEnd = cells - i;
    // Rounded up, whatever little a division loses. Neither half reaches beyond the middle, or places
    // would change their order there.
    float level = min(floor((min(i, fromEnd) * levels + (cells - 0.5)) / cells), floor(0.5 * levels));
    level = i < fromEnd ? level : i > fromEnd ? levels - level : ceil(0.5 * levels);
    float at = subPatch * levels + level, all = subPatches * levels, reciprocal = 1.0 / all;
    return vec2(ratio(at, all, reciprocal), ratio(all - at, all, reciprocal));
}
