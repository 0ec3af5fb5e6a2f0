// The vertices of a sub-patch: points of the patch and their normals.
//
// The cells of a sub-patch are a regular grid. If the level of an edge is lower than the number of
// cells, the vertices on the edge move along it to the positions of its level. They move towards
// the middle of the edge, as the diagonals of the cells point, so that no triangle spans more than
// one segment of the edge. The neighbour has the same vertices on the edge
// (src/tessellation/plan.rs).

layout(quads, equal_spacing, ccw) in;

#ifdef SHARED
layout(binding = 4) uniform samplerBuffer surfaces; // for each, 11 matrix columns and its colour
#else
layout(location = 27) uniform mat4 toClip;
layout(location = 28) uniform mat4 toView;
layout(location = 29) uniform mat4 normalToView;
#endif
#ifdef OVER_DOMAIN
layout(binding = 7) uniform samplerBuffer domains; // for each patch: first u and v, length along u and v
#endif

patch in uvec4 placeOfPatch;
patch in uvec4 cutOfPatch;
#ifdef HELD
patch in PATCH pointsOfPatch;
#endif
#ifdef DEGENERATE
patch in vec2 longest;
#endif

invariant gl_Position;  // different programs draw neighbouring sub-patches, which must meet
layout(location = 0) out vec3 passNormal;    // view space, unit length
layout(location = 1) out vec2 passTessCoord; // (u, v) in the patch, for the trims and the texture
layout(location = 2) out vec4 position;      // view space
#ifdef AOV
layout(location = 3) flat out uint passPatch;
#endif
#ifdef EVALUATED
layout(location = 4) flat out uvec4 passPlace;
#endif
#if defined(EVALUATED) && defined(DEGENERATE)
layout(location = 5) flat out vec2 passLongest;
#endif
#ifdef TRIMMED
layout(location = 7) flat out uint passTrims;
#endif
#if defined(OVER_DOMAIN)
layout(location = 8) out vec2 passPictureCoord; // (u, v) in the domain of the surface, from 0 to 1
#elif !defined(TEXTURED) && (defined(SHARED) || defined(STUDIO))
layout(location = 8) flat out vec3 passPaint; // the surface's colour; linear with STUDIO
#ifndef SHARED
layout(location = 36) uniform vec3 paint;
#endif
#endif

// The parameters t and 1 - t of a vertex along one direction. `across` is its coordinate in the
// other direction: at 0 and 1 the vertex lies on an edge with the level `low` or `high`. Both ends
// of the direction are computed with 1 level, so that all sub-patches that meet there divide the
// same numbers.
vec2 placeAlong(float tessCoord, float across, float cells, float low, float high, float subPatch, float subPatches)
{
    float levels = across == 0.0 ? low : across == 1.0 ? high : cells;
    bool end = tessCoord == 0.0 || tessCoord == 1.0;
    return along(tessCoord, end ? 1.0 : cells, end ? 1.0 : levels, subPatch, subPatches);
}

#ifdef SHARED
// A value of the patch's surface.
vec4 ofSurface(int column)
{
    return texelFetch(surfaces, int(placeOfPatch.z) * 12 + column);
}

// The matrix of the patch's surface that begins at this column.
mat4 matrix(int column)
{
    return mat4(ofSurface(column), ofSurface(column + 1), ofSurface(column + 2), ofSurface(column + 3));
}
#endif

void main()
{
#ifdef SHARED
    mat4 toClip = matrix(0), toView = matrix(4), normalToView = matrix(8);
#endif
    vec4 edges = vec4(uvec4(cutOfPatch.x) >> uvec4(0, 8, 16, 24) & 0xffu);
    vec2 cells = vec2(cutOfPatch.y & 0xffu, cutOfPatch.y >> 8 & 0xffu);
    vec2 subPatches = vec2(cutOfPatch.z & 0xffffu, cutOfPatch.z >> 16);
    vec2 subPatch = vec2(placeOfPatch.w & 0xffffu, placeOfPatch.w >> 16);
    vec2 at = gl_TessCoord.xy;
    vec2 u = placeAlong(at.x, at.y, cells.x, edges.y, edges.w, subPatch.x, subPatches.x);
    vec2 v = placeAlong(at.y, at.x, cells.y, edges.x, edges.z, subPatch.y, subPatches.y);
    vec2 t = vec2(u.x, v.x), s = vec2(u.y, v.y);

#ifdef ANY_DEGREE
    COLUMNS = int(cutOfPatch.y >> 16 & 0xffu);
    ROWS = int(cutOfPatch.y >> 24);
#endif
#ifndef HELD
    PATCH pointsOfPatch;
    fetchPatch(int(placeOfPatch.x), pointsOfPatch);
#endif
    vec4 point;
    POINT du, dv;
    evaluate(pointsOfPatch, t, s, point, du, dv);
#ifdef DEGENERATE
    // Of these, only the second derivatives are new.
    Curved curved = evaluateCurved(pointsOfPatch, t);
    curved.point = point;
    curved.du = du;
    curved.dv = dv;
    vec3 normal = mat3(normalToView) * normalOf(curved, t, longest);
#else
    // Sv × Su, as in the thesis.
    vec3 normal = mat3(normalToView) * cross(tangent(point, dv), tangent(point, du));
#endif
    float size = dot(normal, normal);
    passNormal = size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
    passTessCoord = t;
    vec4 viewPoint = toView * point;
    position = viewPoint / viewPoint.w;
    precise vec4 clip = toClip * point;
    gl_Position = clip;
#ifdef AOV
    passPatch = placeOfPatch.y;
#endif
#ifdef EVALUATED
    passPlace = uvec4(placeOfPatch.xyz, cutOfPatch.y >> 16); // at last, columns and rows of the patch
#endif
#if defined(EVALUATED) && defined(DEGENERATE)
    passLongest = longest;
#endif
#ifdef TRIMMED
    passTrims = cutOfPatch.w;
#endif
#if defined(OVER_DOMAIN)
    vec4 domain = texelFetch(domains, int(placeOfPatch.y));
    passPictureCoord = domain.xy + t * domain.zw;
#elif !defined(TEXTURED) && defined(STUDIO)
#ifdef SHARED
    vec3 paint = ofSurface(11).rgb;
#endif
    passPaint = linearOf(paint); // here, because it would cost a tenth of a frame at each pixel
#elif !defined(TEXTURED) && defined(SHARED)
    passPaint = ofSurface(11).rgb;
#endif
}
