// The vertices of a smooth triangle. Keep in step with src/mesh/pn.rs and src/mesh/phong.rs.
//
// All edges are tessellated at the level of the inside. If the level of an edge is lower, its
// vertices move to the positions of that level, towards the middle of the edge. Both triangles at
// the edge then have the same vertices there (src/tessellation/triangle.rs).

layout(triangles, equal_spacing, ccw) in;

layout(location = 25) uniform int firstPatch;
layout(location = 27) uniform mat4 toClip;
layout(location = 28) uniform mat4 toView;
layout(location = 29) uniform mat4 normalToView;

in vec4 normalOfTriangle[];
#ifdef COLORED
in vec3 colorOfTriangle[];
#endif

patch in uint triangle;
patch in uint levelsOfTriangle;
#ifdef PHONG_TESSELLATION
patch in vec3 edgeMiddles[3];
#else
patch in vec3 edgeThirds[6];
patch in vec3 middle;
patch in vec3 edgeNormals[3];
#endif

layout(location = 0) out vec3 passNormal;    // view space, unit length
layout(location = 1) out vec2 passTessCoord; // texture coordinates; AOV: weights of corners 1, 2
layout(location = 2) out vec4 position;      // view space
#ifdef COLORED
layout(location = 6) out vec3 passColor;
#endif
#ifdef AOV
layout(location = 3) flat out uint passPatch;
#endif

// The barycentric weights of the vertex; on an edge, multiples of 1 over the level of the edge.
vec3 weights()
{
    vec3 at = gl_TessCoord;
    int edge = at.z == 0.0 ? 0 : at.x == 0.0 ? 1 : at.y == 0.0 ? 2 : 3;
    float t = edge == 0 ? at.y : edge == 1 ? at.z : at.x; // from the edge's first corner
    float level = float(levelsOfTriangle >> 8 * edge & 0xffu);
    vec2 moved = along(t, float(levelsOfTriangle >> 24), level, 0.0, 1.0);
    return edge == 0 ? vec3(moved.yx, 0.0)
        : edge == 1 ? vec3(0.0, moved.yx)
        : edge == 2 ? vec3(moved.x, 0.0, moved.y) : at;
}

// The weighted sum of three vectors. On an edge one term is zero, and then the order of the others
// makes no difference to the rounding.
vec3 mean(vec3 a, vec3 b, vec3 c, vec3 by)
{
    precise vec3 sum = (a * by.x + b * by.y) + c * by.z;
    return sum;
}

#ifndef PHONG_TESSELLATION
vec3 edge(int k, float s, float t)
{
    precise vec3 moved = edgeThirds[2 * k] * (3.0 * s * s * t) + edgeThirds[2 * k + 1] * (3.0 * t * t * s);
    return moved;
}
#endif

void main()
{
    vec3 at = weights();
    vec3 a = gl_in[0].gl_Position.xyz, b = gl_in[1].gl_Position.xyz, c = gl_in[2].gl_Position.xyz;
    vec3 normalA = normalOfTriangle[0].xyz, normalB = normalOfTriangle[1].xyz;
    vec3 normalC = normalOfTriangle[2].xyz;
    vec3 linear = mean(normalA, normalB, normalC, at);
#ifdef PHONG_TESSELLATION
    precise vec3 products = vec3(2.0 * at.x * at.y, 2.0 * at.y * at.z, 2.0 * at.z * at.x);
    precise vec3 moved = mean(edgeMiddles[0], edgeMiddles[1], edgeMiddles[2], products);
    vec3 normal = linear;
#else
    precise vec3 edges = (edge(0, at.x, at.y) + edge(1, at.y, at.z)) + edge(2, at.z, at.x);
    precise vec3 moved = edges + middle * (6.0 * at.x * at.y * at.z);
    vec3 normal = mean(normalA, normalB, normalC, at * at)
        + mean(edgeNormals[0], edgeNormals[1], edgeNormals[2], at * at.yzx);
    // If opposite normals cancel out: the linearly interpolated normal, or else that of the flat
    // triangle.
    normal = dot(normal, normal) > 1e-8 ? normal : linear;
#endif
    vec3 flatNormal = cross(b - a, c - a);
    float area = dot(flatNormal, flatNormal);
    normal = dot(normal, normal) > 1e-8 ? normal : area > 0.0 ? flatNormal * inversesqrt(area) : vec3(0.0);
    normal = mat3(normalToView) * normal;
    float size = dot(normal, normal);
    passNormal = size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
    precise vec4 point = vec4(mean(a, b, c, at) + moved, 1.0);
    position = toView * point;
    precise vec4 clip = toClip * point;
    gl_Position = clip;
#ifdef COLORED
    passColor = mean(colorOfTriangle[0], colorOfTriangle[1], colorOfTriangle[2], at);
#endif
#ifdef AOV
    passTessCoord = at.yz;
    passPatch = uint(firstPatch) + triangle;
    // Inwards, because normals of surfaces are Sv × Su. `common/aov.frag` reverses both.
    passNormal = -passNormal;
#else
    passTessCoord = at.x * vec2(gl_in[0].gl_Position.w, normalOfTriangle[0].w)
        + at.y * vec2(gl_in[1].gl_Position.w, normalOfTriangle[1].w)
        + at.z * vec2(gl_in[2].gl_Position.w, normalOfTriangle[2].w);
#endif
}
