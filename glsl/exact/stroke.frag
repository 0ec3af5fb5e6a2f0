// A segment of a stroke, a parabola: the samples within half a width of it, as part of the face on their side of it. The
// depth is that of the plane of the face, shifted a little (src/tessellation/strokes.rs). With LINES, a segment of a
// line.

layout(binding = 8) uniform samplerBuffer strokes;

layout(location = 0) flat in int segment;
layout(location = 1) noperspective in vec2 place;

layout(location = 26) uniform vec4 viewport;
layout(location = 38) uniform mat4 rayStart;     // from (x/w, y/w, 1, 0) to the point seen there at distance 0
layout(location = 39) uniform mat4 rayDirection; // and to what is added for each unit of distance along the view axis
layout(location = 40) uniform vec4 depthTerms;   // depth: (x d + y) / (z d + w) at the distance d

#ifdef AOV
layout(location = 24) uniform mat4 viewToWorld;

layout(location = 0) out vec4 uvAov;       // u and v as shares of the domain, -1 - number of a patch, 1
layout(location = 1) out vec4 positionAov; // world space; 1
layout(location = 2) out vec4 normalAov;   // world space, unit Su × Sv; distance along view axis
#ifdef CURVATURE_AOV
layout(location = 3) out vec4 curvatureAov; // none: src/prepared/captures.rs sets it
#endif
#else
out vec4 fragmentColor;
#endif

// The largest difference in distance from the edge, as a multiple of that on the screen.
#ifdef LINES
const float STEEPEST = 4.0;
#else
const float STEEPEST = 8.0;
#endif

// What the place of a segment depends on, and its codes. The bits: 0 and 1, the start or the end is cut; 2, it is known
// which side is the outside of a solid; 3 and 4, the normal of the face to the left or right points inwards.
struct Segment {
    vec4 ends;
    float halfWidth; // negative if only the left side is drawn
    vec3 sag;        // how far the middle is off the middle of the ends, in pixels; the same of the distances
    int codes;
};

// The place of a parameter from 0 to 1, and the derivative.
vec2 placeAt(Segment stroke, float at)
{
    return mix(stroke.ends.xy, stroke.ends.zw, at) + 4.0 * at * (1.0 - at) * stroke.sag.xy;
}

vec2 slopeAt(Segment stroke, float at)
{
    return stroke.ends.zw - stroke.ends.xy + 4.0 * (1.0 - 2.0 * at) * stroke.sag.xy;
}

// The parameter of the point nearest to a place; the squared distance from that point, more than the reach of the stroke
// where it does not draw; and above 0 if the place lies to the left.
vec3 nearest(Segment stroke, vec2 place)
{
    vec2 along = stroke.ends.zw - stroke.ends.xy;
    float size = dot(along, along);
    float unclamped = size > 0.0 ? dot(place - stroke.ends.xy, along) / size : 0.0;
    if (stroke.sag.xy != vec2(0.0)) {
        // Newton's method. Sags are below an eighth of the length (MOST_SAG).
        for (int i = 0; i < 2; ++i) {
            vec2 off = place - placeAt(stroke, unclamped), slope = slopeAt(stroke, unclamped);
            float square = dot(slope, slope);
            unclamped += dot(off, slope) / max(square + 8.0 * dot(off, stroke.sag.xy), 0.25 * square);
            unclamped = clamp(unclamped, -1.0, 2.0);
        }
    }
    float at = clamp(unclamped, 0.0, 1.0);
    vec2 off = place - placeAt(stroke, at), slope = slopeAt(stroke, at);
    float left = slope.x * off.y - slope.y * off.x;
    bool isOn = stroke.halfWidth > 0.0 || left >= 0.0;
#ifndef LINES
    isOn = isOn && ((stroke.codes & 1) == 0 || unclamped >= 0.0) && ((stroke.codes & 2) == 0 || unclamped <= 1.0);
#endif
    return vec3(at, isOn ? dot(off, off) : 1e30, left);
}

void main()
{
    int first = 10 * segment;
    vec4 shape = texelFetch(strokes, first + 1), bend = texelFetch(strokes, first + 2);
    Segment stroke = Segment(texelFetch(strokes, first), shape.z, bend.xyz, int(bend.w));
    float reach = shape.z * shape.z;
#if SAMPLES > 1
    int kept = 0;
    for (int i = 0; i < SAMPLES; ++i)
        if (nearest(stroke, interpolateAtSample(place, i)).y <= reach)
            kept |= 1 << i;
#ifndef LINES // whose depth has derivatives
    if (kept == 0)
        discard;
#endif
    gl_SampleMask[0] = kept;
    vec3 at = nearest(stroke, place);
#else
    vec3 at = nearest(stroke, place);
    if (at.y > reach)
        discard;
#endif
    int side = at.z < 0.0 && shape.z > 0.0 ? 2 : 0;
    vec4 start = texelFetch(strokes, first + 3 + side), end = texelFetch(strokes, first + 4 + side);

    // Along the edge, distances change with the place on the screen as those of a straight line do, apart from the sag.
    bool parallel = rayDirection[0].x == 0.0 && rayDirection[1].y == 0.0;
    float across = mix(shape.y, shape.x, at.x);
    float share = parallel ? at.x : at.x * shape.x / across;
    float sag = 4.0 * at.x * (1.0 - at.x) * stroke.sag.z;
    float distance = parallel ? mix(shape.x, shape.y, at.x) + sag
        : shape.x * shape.y / across * (1.0 + sag / across);
    vec2 middle = placeAt(stroke, at.x);
    vec4 here = vec4(middle / viewport.zw, 1.0, 0.0), there = vec4(place / viewport.zw, 1.0, 0.0);
    vec3 onEdge = (rayStart * here + distance * (rayDirection * here)).xyz;
    vec3 from = (rayStart * there).xyz, direction = (rayDirection * there).xyz;
    // The size of a pixel.
    float pixel = abs(rayStart[0].x + distance * rayDirection[0].x) / viewport.z;

    vec3 normal = mix(start.xyz, end.xyz, share);
    float towards = dot(normal, direction);
    float farther = dot(normal, onEdge - from) - towards * distance;
    float halfWidth = abs(shape.z);
    float most = STEEPEST * pixel * min(sqrt(at.y), halfWidth);
    // Without a division by what may be 0.
    farther = abs(farther) >= most * abs(towards) ? sign(farther) * sign(towards) * most : farther / towards;
#ifndef LINES
    // Where the face comes nearer, it covers the stroke itself.
    farther = max(farther, 0.0);
#endif
    float depth = distance + farther;

    float size = dot(normal, normal);
    normal = size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, -1.0);
#ifdef AOV
    vec4 shares = texelFetch(strokes, first + 7 + side / 2), sags = texelFetch(strokes, first + 9);
    vec2 uv = mix(shares.xy, shares.zw, share) + 4.0 * share * (1.0 - share) * (side == 0 ? sags.xy : sags.zw);
    uvAov = vec4(uv, -1.0 - end.w, 1.0);
    // The pixel shows the nearest point of the edge.
    positionAov = vec4((viewToWorld * vec4(onEdge, 1.0)).xyz, 1.0);
    normalAov = vec4(normalize(mat3(viewToWorld) * normal), distance);
#ifdef CURVATURE_AOV
    curvatureAov = vec4(0.0);
#endif
#else
    vec3 paint = floor(start.w / vec3(65536.0, 256.0, 1.0));
    paint = (paint - 256.0 * floor(paint / 256.0)) / 255.0;
#if defined(ZEBRA)
    fragmentColor = vec4(zebra(from + depth * direction, normal), 1.0);
#elif defined(ISOPHOTES)
    fragmentColor = vec4(isophotes(normal), 1.0);
#elif defined(DRAFT)
    fragmentColor = vec4(draft(from + depth * direction, normal), 1.0);
#elif defined(STUDIO)
    // At a silhouette, normals that are interpolated may point a little away from the eye.
    vec3 outwards = vec3(0.0);
    if ((stroke.codes & 4) != 0)
        outwards = (stroke.codes & (side == 0 ? 8 : 16)) == 0 ? normal : -normal;
    fragmentColor = vec4(lit(linearOf(paint), from + depth * direction, -normal, outwards), 1.0);
#elif defined(PHONG)
    fragmentColor = vec4(lit(paint, from + depth * direction, -normal), 1.0); // Sv × Su, as in the thesis
#elif defined(NORMALS)
    fragmentColor = vec4(0.5 - 0.5 * normal, 1.0);
#else
    fragmentColor = vec4(paint, 1.0);
#endif
#endif
    depth += shape.w * halfWidth * pixel;
#if defined(LINES) && SAMPLES > 1
    // The samples of the pixel share this depth, those of the face do not: the face is nowhere in front.
    depth -= min(0.5 * fwidth(depth), STEEPEST * pixel);
#endif
    gl_FragDepth = clamp((depthTerms.x * depth + depthTerms.y) / (depthTerms.z * depth + depthTerms.w), 0.0, 1.0);
}
