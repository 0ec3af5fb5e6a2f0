// Places along an edge, the same from both of its sides.

// One whole number over another, rounded correctly on drivers whose division is not: 1/2 and 2/4 meet.
float ratio(int a, int b)
{
    precise float quotient = float(a) / float(b);
    precise float rest = fma(-quotient, float(b), float(a));
    precise float corrected = quotient + rest / float(b);
    return corrected;
}

// t and 1 - t along one direction: a whole number of levels over all of the patch's.
vec2 along(float tessCoord, int cells, int levels, int part, int parts)
{
    int i = int(round(tessCoord * float(cells)));
    int fromEnd = cells - i, nearer = min(i, fromEnd);
    // Neither half reaches beyond the middle, or places would change their order there.
    int level = min((nearer * levels + cells - 1) / cells, levels / 2);
    level = i < fromEnd ? level : i > fromEnd ? levels - level : (levels + 1) / 2;
    int at = part * levels + level, all = parts * levels;
    return vec2(ratio(at, all), ratio(all - at, all));
}
