// The exact method's trims: what is cut out of the domain, right at every sample. Keep in step with
// src/trim/{exact,grid,lattice,pieces,shapes}.rs, which decide bit for bit alike; grid.rs says what
// the words mean and why.
//
// Compiled in is what a surface has: LOOPS, SHAPES.

layout(std430, binding = 1) readonly buffer trimGridSsbo
{
    uint trimGrid_data[];
};

const uint LIST = 2u;
const uint FINER = 3u;

float trimFloat(uint at)
{
    return uintBitsToFloat(trimGrid_data[at]);
}

vec2 trimPoint(uint at)
{
    return vec2(trimFloat(at), trimFloat(at + 1u));
}

bool within(vec2 uv, vec4 box)
{
    return all(greaterThanEqual(uv, box.xy)) && all(lessThan(uv, box.zw));
}

// The cell of a sample in a lattice, row by row.
uint cellOf(vec2 uv, vec2 least, vec2 scale, uvec2 size)
{
    precise vec2 place = (uv - least) * scale;
    uvec2 cell = min(uvec2(place), size - 1u);
    return cell.y * size.x + cell.x;
}

#ifdef LOOPS
layout(location = 24) uniform vec4 loopBox;    // least and greatest (u, v) of all loops
layout(location = 25) uniform vec2 loopScale;  // cells for each unit of the domain
layout(location = 26) uniform uvec3 loopCells; // columns, rows, the word where the cells begin
layout(location = 27) uniform bool keepInside;

// Whether the ray from uv towards greater u crosses a piece. The half-open test of the row decides
// topology on stored bits alone. Where uv lies in the piece's box, the box is halved until one side
// holds uv no more.
bool crosses(uint at, vec2 low, vec2 high, vec2 uv)
{
    if ((low.y <= uv.y) == (high.y <= uv.y))
        return false;
    float least = min(low.x, high.x), most = max(low.x, high.x);
    if (uv.x < least || uv.x >= most)
        return uv.x < least;
    precise vec2 a = low, b = trimPoint(at + 4u), c = trimPoint(at + 6u), d = high;
    for (int halving = 0; halving < 24; ++halving) {
        precise vec2 ab = (a + b) * 0.5, bc = (b + c) * 0.5, cd = (c + d) * 0.5;
        precise vec2 abc = (ab + bc) * 0.5, bcd = (bc + cd) * 0.5;
        precise vec2 middle = (abc + bcd) * 0.5;
        if (middle.y <= uv.y) {
            a = middle;
            b = bcd;
            c = cd;
        } else {
            b = ab;
            c = abc;
            d = middle;
        }
        least = min(a.x, d.x);
        if (uv.x < least || uv.x >= max(a.x, d.x))
            return uv.x < least;
    }
    return false;
}

bool insideLoops(vec2 uv)
{
    if (!within(uv, loopBox))
        return false;
    uint cell = trimGrid_data[loopCells.z + cellOf(uv, loopBox.xy, loopScale, loopCells.xy)];
    if ((cell & 3u) == FINER) {
        uint at = cell >> 2;
        uvec2 size = uvec2(trimGrid_data[at + 4u], trimGrid_data[at + 5u]);
        cell = trimGrid_data[at + 6u + cellOf(uv, trimPoint(at), trimPoint(at + 2u), size)];
    }
    if ((cell & 3u) != LIST)
        return (cell & 1u) == 1u;
    uint list = cell >> 2;
    uint head = trimGrid_data[list];
    bool inside = (head & 1u) == 1u;
    for (uint end = list + (head >> 1); list < end;) {
        uint reference = trimGrid_data[++list];
        uint at = (reference >> 2) * 8u;
        vec2 low = trimPoint(at), high = trimPoint(at + 2u);
        uint beyond = reference & 3u;
        bool endReached = beyond != 0u && (beyond == 1u ? low.y : high.y) <= uv.y;
        inside = (inside != crosses(at, low, high, uv)) != endReached;
    }
    return inside;
}
#endif

#ifdef SHAPES
layout(location = 28) uniform vec4 shapeBox;
layout(location = 29) uniform vec2 shapeScale;
layout(location = 30) uniform uvec3 shapeCells;

bool cutByShape(uint reference, vec2 uv)
{
    uint at = reference >> 2;
    vec2 first = trimPoint(at), second = trimPoint(at + 2u);
    if ((reference & 3u) == 1u)
        return uv.x >= first.x && uv.x <= first.y && uv.y >= second.x && uv.y <= second.y;
    precise vec2 off = uv - first;
    precise vec2 terms = (second * off + trimPoint(at + 4u)) * off;
    precise float sum = terms.x + terms.y + trimFloat(at + 6u);
    return sum <= 0.0;
}

bool cutByShapes(vec2 uv)
{
    if (!within(uv, shapeBox))
        return false;
    uint cell = trimGrid_data[shapeCells.z + cellOf(uv, shapeBox.xy, shapeScale, shapeCells.xy)];
    if ((cell & 3u) != LIST)
        return (cell & 1u) == 1u;
    uint list = cell >> 2;
    for (uint end = list + (trimGrid_data[list] >> 1); list < end;)
        if (cutByShape(trimGrid_data[++list], uv))
            return true;
    return false;
}
#endif

// Whether any trim cuts uv.
bool cut(vec2 uv)
{
    // The last number below 1: the domain's far borders belong to the cells before them.
    uv = clamp(uv, 0.0, 0.99999994);
#ifdef SHAPES
    if (cutByShapes(uv))
        return true;
#endif
#ifdef LOOPS
    return insideLoops(uv) != keepInside;
#else
    return false;
#endif
}
