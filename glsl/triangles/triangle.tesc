// The control points of a smooth triangle, and how finely it is cut. Keep in step with src/mesh/pn.rs and
// src/mesh/phong.rs.
//
// Edge k runs from corner k to the next. Control points are kept as what moves them off the flat
// triangle: those of an edge off its thirds (PN) or its middle (Phong), so that neighbours get the
// same numbers whichever way each of them runs.

layout(vertices = 3) out;

layout(binding = 5) uniform usamplerBuffer levels; // of the edges from bit 0, 8 and 16, inside from 24
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
patch out vec3 edgeThirds[6]; // near corner k, near the next
patch out vec3 middle;
patch out vec3 edgeNormals[3];
#endif

// The part of a vector along a unit vector or zero.
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
            // The sum of the ends' normals, mirrored in the plane that halves the edge.
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
