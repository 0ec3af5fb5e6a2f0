// The control points and the levels of a smooth triangle. Keep in step with src/mesh/pn.rs and
// src/mesh/phong.rs.
//
// Edge k runs from corner k to the next. Control points are stored as offsets from the flat
// triangle: those of an edge as offsets from its thirds (PN) or its middle (Phong). Two triangles
// compute the same offsets for their common edge, although it runs in opposite directions in them.

layout(vertices = 3) out;

layout(binding = 5) uniform usamplerBuffer levels; // of edges from bits 0, 8, 16; inside from 24
#ifdef PHONG_TESSELLATION
layout(location = 30) uniform float alpha;
#endif

in vec4 normalOfCorner[];
in vec3 leavingCorner[];
in vec3 arrivingCorner[];
flat in uint triangleOfCorner[];
#ifdef COLORED
in vec3 colorOfCorner[];

out vec3 colorOfTriangle[];
#endif

out vec4 normalOfTriangle[];

patch out uint triangle;
patch out uint levelsOfTriangle;
#ifdef PHONG_TESSELLATION
patch out vec3 edgeMiddles[3];
#else
patch out vec3 edgeThirds[6]; // of edge k: 2k near corner k, 2k + 1 near the next
patch out vec3 middle;
patch out vec3 edgeNormals[3];
#endif

// The projection of a vector onto a unit vector; zero if `unit` is zero.
vec3 partAlong(vec3 vector, vec3 unit)
{
    precise float size = (vector.x * unit.x + vector.y * unit.y) + vector.z * unit.z;
    precise vec3 part = unit * size;
    return part;
}

vec3 direction(vec3 sum)
{
    float size = length(sum);
    return size > 1e-4 ? sum / size : vec3(0.0);
}

void main()
{
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    normalOfTriangle[gl_InvocationID] = normalOfCorner[gl_InvocationID];
#ifdef COLORED
    colorOfTriangle[gl_InvocationID] = colorOfCorner[gl_InvocationID];
#endif
    if (gl_InvocationID == 0) {
#ifndef PHONG_TESSELLATION
        vec3 moved = vec3(0.0);
#endif
        for (int k = 0; k < 3; ++k) {
            int next = k == 2 ? 0 : k + 1;
            precise vec3 edge = gl_in[next].gl_Position.xyz - gl_in[k].gl_Position.xyz;
            precise vec3 near = partAlong(edge, leavingCorner[k]);
            precise vec3 far = partAlong(-edge, arrivingCorner[next]);
#ifdef PHONG_TESSELLATION
            precise vec3 toMiddle = (near + far) * (-0.5 * alpha);
            edgeMiddles[k] = toMiddle;
#else
            precise vec3 nearThird = near / -3.0, farThird = far / -3.0;
            edgeThirds[2 * k] = nearThird;
            edgeThirds[2 * k + 1] = farThird;
            moved += nearThird + farThird;
            // The sum of the normals at both ends, reflected in the perpendicular bisector plane of
            // the edge.
            vec3 unit = direction(edge), sum = normalOfCorner[k].xyz + normalOfCorner[next].xyz;
            edgeNormals[k] = direction(sum - 2.0 * partAlong(sum, unit));
#endif
        }
#ifndef PHONG_TESSELLATION
        middle = moved / 4.0;
#endif
        triangle = triangleOfCorner[0];
        uint word = texelFetch(levels, int(triangleOfCorner[0])).x;
        levelsOfTriangle = word;
        float level = float(word >> 24);
        gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = level;
        gl_TessLevelInner[0] = level;
    }
}
