// Listings 3 to 6: the double de Casteljau algorithm. Keep in step with src/thesis/normal.rs.
//
//  v    12 13 14 15     Rows run along u. The first pass evaluates each row at u, the second
//  ^     8  9 10 11     the curve of the SIDE results at v.
//  |     4  5  6  7
//  |     0  1  2  3
//  +----------> u       (SIDE = 4; a 5×5 patch likewise)

layout(quads, equal_spacing, ccw) in;

layout(location = 1) uniform mat4 modelMatrix;
layout(location = 2) uniform mat4 viewMatrix;
layout(location = 3) uniform mat4 projectionMatrix;
layout(location = 4) uniform vec3 part; // sub-patch in the domain: first u, first v, side length

layout(location = 0) out vec3 passNormal;    // view space, unit length
layout(location = 1) out vec2 passTessCoord; // (u, v), for the trims
layout(location = 2) out vec4 position;      // view space
layout(location = 4) out vec2 passUVCoord;   // (u, v), for the texture
#ifdef AOV
patch in uint numberOfPatch;
layout(location = 3) flat out uint passPatch;
#endif

// Unit length, or zero where the listing would divide by zero.
vec3 direction(vec3 v)
{
    float size = length(v);
    return size > 0.0 ? v / size : vec3(0.0);
}

// Listing 4. `index` selects the tangent that this pass overwrites: 0 for tangV, which is the
// tangent along u, and 1 for tangU, the tangent along v.
vec4 deCasteljau(vec4 points[SIDE], inout vec3 tangU, inout vec3 tangV, float t, int index)
{
    for (int last = SIDE - 2; last >= 0; --last) {
        if (last == 0) {
            // If all weights are 1, this is the difference of the last two points, as in the
            // listing.
            vec3 tangent =
                direction(points[1].xyz / points[1].w - points[0].xyz / points[0].w);
            if (index == 1)
                tangU = tangent;
            else
                tangV = tangent;
        }
        for (int j = 0; j <= last; ++j)
            points[j] = (1.0 - t) * points[j] + t * points[j + 1];
    }
    return points[0];
}

// Listing 5. Every row overwrites tangV, so the tangent along u is that of the last row. It is
// correct only on the border v = 1. This error of the thesis is kept, so that it can be measured.
void doubleDeCasteljau(float u, float v, out vec4 point, out vec3 tangU, out vec3 tangV)
{
    tangU = vec3(0.0);
    tangV = vec3(0.0);
    vec4 uPositions[SIDE];
    for (int row = 0; row < SIDE; ++row) {
        vec4 points[SIDE];
        for (int column = 0; column < SIDE; ++column)
            points[column] = gl_in[row * SIDE + column].gl_Position;
        uPositions[row] = deCasteljau(points, tangU, tangV, u, 0);
    }
    point = deCasteljau(uPositions, tangU, tangV, v, 1);
}

// Listing 6, with the matrices that it leaves out.
void main()
{
    float u = part.x + part.z * gl_TessCoord.x;
    float v = part.y + part.z * gl_TessCoord.y;
    vec4 point;
    vec3 tangU, tangV;
    doubleDeCasteljau(u, v, point, tangU, tangV);

    // The cross product of transformed vectors is, up to a factor, the normal matrix times their
    // cross product.
    mat3 toView = mat3(viewMatrix) * mat3(modelMatrix);
    passNormal = direction(cross(toView * tangU, toView * tangV));
    passTessCoord = vec2(u, v);
    passUVCoord = vec2(u, v);
    vec4 viewPoint = viewMatrix * (modelMatrix * point);
    position = viewPoint / viewPoint.w;
    gl_Position = projectionMatrix * viewPoint;
#ifdef AOV
    passPatch = numberOfPatch;
#endif
}
