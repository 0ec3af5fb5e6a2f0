// The exact method's trims: whether a point of the domain is cut. Keep in step with
// src/trim/{exact,grid,uniform_grid,pieces,shapes}.rs, which make the same decisions bit for bit;
// grid.rs and shapes.rs describe the words of the buffer.
//
// Only what a surface has is compiled in: LOOPS; FINER_LOOPS, some cells are subdivided; LONG_LISTS,
// some cells list more than 32 pieces; FILL_RULES, paths have their own fill rules; SHAPES, circles,
// rectangles and ellipses.

// The grids of all surfaces. Two views of one buffer: words, and texels of four floats. (With Mesa's
// software driver, a fetch from a buffer texture takes a tenth of the time of one from a storage
// buffer, and less than a uniform.)
layout(binding = 1) uniform usamplerBuffer trimWords;
layout(binding = 2) uniform samplerBuffer trimPoints;

// Which of the grids decides: from bit 0, the index of its first word divided by 8; from bit 24, the
// number of columns of the loops' cells as a power of two. They have as many rows.
#ifdef GEOMETRY
layout(location = 15) flat in uint passTrims;
#else
layout(location = 7) flat in uint passTrims;
#endif

const uint HEADER_WORDS = 4u;
const uint LIST = 2u;
const uint FINER = 4u;
const uint LAST = 4u;
const uint LEFT = 8u;
const uint FALLS = 16u;
const uint EVEN_ODD = 1u;
const uint LAST_HEAD = 2u;

// The indices of words and texels count from the beginning of the grid.
uint trimWord(uint at)
{
    return texelFetch(trimWords, int((passTrims & 0xffffffu) * 8u + at)).x;
}

vec4 trimPoint(int at)
{
    return texelFetch(trimPoints, int(passTrims & 0xffffffu) * 2 + at);
}

// The index of the cell that contains a point. The unit of the point's coordinates is a cell.
uint cellAt(vec2 place, uint columns)
{
    // Never negative; signed conversions are faster with some drivers.
    return uint(int(place.y) * int(columns) + int(place.x));
}

#ifdef LOOPS
// The cross product: positive if b points to the left of a.
float crossed(vec2 a, vec2 b)
{
    precise float value = a.x * b.y - a.y * b.x;
    return value;
}

// The contribution of one crossing of a piece to the winding number.
int turnOf(uint reference)
{
#ifdef FILL_RULES
    return (reference & FALLS) != 0u ? -1 : 1;
#else
    return 1; // Only the parity matters.
#endif
}

// The contribution of the pieces of a list to the winding number. The list begins at the word `at`,
// which is moved past its end. The ray from uv runs towards greater u.
int crossings(inout uint at, vec2 uv)
{
    int number = 0;
    bool last = false;
#ifdef LONG_LISTS
    while (!last)
#endif
    {
        // Tests every piece, and marks those that must be halved. The halving is in a loop of its
        // own, because drivers without branches execute this whole loop body for every pixel.
        uint first = at, near = 0u, mark = 1u;
        do {
            uint reference = trimWord(at);
            vec4 ends = trimPoint(int(reference >> 5) * 2);
            // The half-open row test and the box test decide the topology from stored bits alone.
            bool lowReached = ends.y <= uv.y, highReached = ends.w <= uv.y;
            bool inRow = lowReached != highReached;
            bool leftOfBox = uv.x < min(ends.x, ends.z);
            bool inBox = inRow && !leftOfBox && uv.x < max(ends.x, ends.z);
            // In the box, the whole curve lies on one side of its chord.
            bool left = (reference & LEFT) != 0u;
            bool outside = (left ? 1.0 : -1.0) * crossed(ends.zw - ends.xy, uv - ends.xy) < 0.0;
            bool crosses = inBox ? outside && !left : inRow && leftOfBox;
            bool lowEnd = (reference & 1u) != 0u && lowReached;
            bool highEnd = (reference & 2u) != 0u && highReached;
            number += turnOf(reference) * (int(crosses) + int(highEnd) - int(lowEnd));
            near |= inBox && !outside ? mark : 0u;
            mark <<= 1;
            last = (reference & LAST) != 0u;
            ++at;
#ifdef LONG_LISTS
        } while (!last && mark != 0u);
#else
        } while (!last);
#endif

        // Halves the marked pieces, one piece after the other. Each iteration is one halving.
        int halvings = 0, turn = 1;
        bool left = false;
        vec2 point = vec2(0.0), a = vec2(0.0), b = vec2(0.0), c = vec2(0.0), d = vec2(0.0);
        while (near != 0u) {
            if (halvings == 0) {
                uint reference = trimWord(first + uint(findLSB(near)));
                left = (reference & LEFT) != 0u;
                turn = turnOf(reference);
                int piece = int(reference >> 5) * 2;
                vec4 ends = trimPoint(piece), legs = trimPoint(piece + 1);
                precise vec2 chord = ends.zw - ends.xy, inner = chord - legs.zw;
                point = uv - ends.xy;
                a = vec2(0.0);
                b = legs.xy;
                c = inner;
                d = chord;
            }
            // De Casteljau's averages without their factors ½. Multiplying by ½ is exact, so it
            // makes no difference when this is done.
            precise vec2 ab = a + b, bc = b + c, cd = c + d;
            precise vec2 abc = ab + bc, bcd = bc + cd;
            precise vec2 middle = (abc + bcd) * 0.125;
            bool above = middle.y <= point.y;
            b = above ? bcd * 0.25 : ab * 0.5;
            c = above ? cd * 0.5 : abc * 0.25;
            a = above ? middle : a;
            d = above ? d : middle;
            // The curve lies between the chord of each half and the tangent in the middle.
            float side = left ? 1.0 : -1.0;
            bool outside = side * crossed(d - a, point - a) < 0.0;
            bool beyond = side * crossed(bcd - abc, point - middle) > 0.0;
            ++halvings;
            if (outside || beyond || halvings == 24) {
                number += turn * int(outside ? !left : beyond && left);
                near &= near - 1u;
                halvings = 0;
            }
        }
    }
    return number;
}

bool cutByLoops(vec2 uv)
{
    uint columns = 1u << (passTrims >> 24);
    uint cell = trimWord(HEADER_WORDS + cellAt(uv * float(columns), columns));
#ifdef FINER_LOOPS
    if ((cell & 7u) == FINER) {
        uint at = cell >> 3;
        vec2 least = uintBitsToFloat(uvec2(trimWord(at), trimWord(at + 1u)));
        vec2 scale = uintBitsToFloat(uvec2(trimWord(at + 2u), trimWord(at + 3u)));
        precise vec2 place = (uv - least) * scale;
        cell = trimWord(at + 5u + cellAt(place, trimWord(at + 4u)));
    }
#endif
    bool turned = (cell & 1u) == 1u;
    if ((cell & LIST) == 0u)
        return turned;
    uint at = cell >> 3;
#ifdef FILL_RULES
    // A sample is inside if it is inside at least one path. Each path has a head and a list.
    for (;;) {
        uint head = trimWord(at++);
        int number = (int(head) >> 2) + crossings(at, uv);
        bool inside = (head & EVEN_ODD) != 0u ? (number & 1) != 0 : number != 0;
        if (inside || (head & LAST_HEAD) != 0u)
            return inside != turned;
    }
#else
    return ((crossings(at, uv) & 1) != 0) != turned;
#endif
}
#endif

#ifdef SHAPES
bool cutByShape(uint reference, vec2 uv)
{
    int at = int(reference >> 3);
    vec4 first = trimPoint(at), second = trimPoint(at + 1);
    if ((reference & 3u) == 1u)
        return uv.x >= first.x && uv.x <= first.y && uv.y >= first.z && uv.y <= first.w;
    precise vec2 off = uv - first.xy;
    precise vec2 terms = (first.zw * off + second.xy) * off;
    precise float sum = terms.x + terms.y + second.z;
    return sum <= 0.0;
}

bool cutByShapes(vec2 uv)
{
    uint columns = trimWord(0u);
    uint cell = trimWord(trimWord(1u) + cellAt(uv * float(columns), columns));
    bool isCut = (cell & 1u) == 1u;
    if ((cell & LIST) == 0u)
        return isCut;
    for (uint at = cell >> 3, reference = 0u; !isCut && (reference & LAST) == 0u; ++at) {
        reference = trimWord(at);
        isCut = cutByShape(reference, uv);
    }
    return isCut;
}
#endif

// Whether any trim cuts uv.
bool cut(vec2 uv)
{
    // The largest float below 1: the far borders of the domain belong to the cells before them.
    uv = clamp(uv, 0.0, 0.99999994);
#ifdef SHAPES
    if (cutByShapes(uv))
        return true;
#endif
#ifdef LOOPS
    return cutByLoops(uv);
#else
    return false;
#endif
}
