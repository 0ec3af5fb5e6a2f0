// AOVs: values of a pixel instead of a colour. Trims are decided at the pixel's centre.
//
// The driver's interpolation is imprecise on triangles that are seen edge-on and thinner than a
// thousandth of a pixel. The barycentric weights are therefore computed here, from the triangle's
// vertices and the pixel's centre.

layout(location = 0) flat in vec3 cornerClips[3]; // x, y and w
layout(location = 3) flat in vec3 cornerNormals[3];
layout(location = 6) flat in vec3 cornerPositions[3]; // view space
layout(location = 9) flat in vec2 cornerTessCoords[3];
layout(location = 12) flat in uint patchOfTriangle;

layout(location = 24) uniform mat4 viewToWorld;
#ifndef EVALUATED
layout(location = 26) uniform vec4 viewport; // first pixel, half of width and height
#endif

layout(location = 0) out vec4 uvAov;       // u, v, number of the patch, 1
layout(location = 1) out vec4 positionAov; // world space; 1
layout(location = 2) out vec4 normalAov;   // world space, unit Su × Sv; distance along view axis
#ifdef CURVATURE_AOV
layout(location = 3) out vec4 curvatureAov; // Gaussian, mean, the principal one of larger magnitude; 1
#endif

#ifdef FAR_DEPTH
// Depth is proportional to the distance along the view axis, so its relative precision is the same
// at every distance.
layout(location = 32) uniform float depthScale;
#endif

// The perspective-correct barycentric weights of the pixel's centre.
vec3 cornerWeights()
{
    vec2 center = (gl_FragCoord.xy - viewport.xy) / viewport.zw - 1.0;
    vec2 offsets[3]; // of the vertices from the pixel's centre, in pixels, times w
    vec3 w;
    for (int i = 0; i < 3; ++i) {
        w[i] = cornerClips[i].z;
        offsets[i] = viewport.zw * (cornerClips[i].xy - center * w[i]);
    }
    vec3 weights = cross(vec3(offsets[0].x, offsets[1].x, offsets[2].x),
        vec3(offsets[0].y, offsets[1].y, offsets[2].y));
    float sum = weights.x + weights.y + weights.z;
    weights /= sum;
    // Vertices behind the eye have no position on the screen.
    bool before = min(w.x, min(w.y, w.z)) > 0.0;
    vec2 corners[3] = vec2[](offsets[0] / w.x, offsets[1] / w.y, offsets[2] / w.z);
    vec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
    float longest = max(dot(a, a), max(dot(b, b), dot(b - a, b - a)));
    bool thin = abs(a.x * b.y - a.y * b.x) < 1e-3 * sqrt(longest);
    bool outside = !(min(weights.x, min(weights.y, weights.z)) >= 0.0);
    if (before && (thin || outside)) {
        // Because of rounding, the triangle misses the pixel's centre, or its width is lost. The
        // point of its border that is nearest to the centre is taken instead.
        float nearest = 1e30;
        for (int i = 0; i < 3; ++i) {
            int j = i == 2 ? 0 : i + 1;
            vec2 edge = corners[j] - corners[i];
            float square = dot(edge, edge);
            float t = square > 0.0 ? clamp(-dot(corners[i], edge) / square, 0.0, 1.0) : 0.0;
            vec2 place = corners[i] + t * edge;
            if (dot(place, place) < nearest) {
                nearest = dot(place, place);
                weights = vec3(0.0);
                weights[i] = (1.0 - t) / w[i];
                weights[j] = t / w[j];
            }
        }
    }
    weights = max(weights, 0.0);
    return weights / (weights.x + weights.y + weights.z);
}

void main()
{
    vec3 weights = cornerWeights();
    vec2 uv = mat3x2(cornerTessCoords[0], cornerTessCoords[1], cornerTessCoords[2]) * weights;
#ifdef CURVATURE
    vec3 ignored;
    vec3 curvature = curvatureAt(uv, ignored);
    float largest = curvature.y + (curvature.y < 0.0 ? -curvature.z : curvature.z);
    curvatureAov = vec4(curvature.xy, largest, 1.0);
#elif defined(CURVATURE_AOV)
    curvatureAov = vec4(0.0);
#endif
#ifdef TRIMMED
    if (cut(uv))
        discard;
#endif
    vec3 position = mat3(cornerPositions[0], cornerPositions[1], cornerPositions[2]) * weights;
#ifdef PIXEL_NORMALS
    vec3 normal = normalAt(uv);
#else
    vec3 normal = mat3(cornerNormals[0], cornerNormals[1], cornerNormals[2]) * weights;
#endif
    uvAov = vec4(uv, float(patchOfTriangle), 1.0);
    positionAov = vec4((viewToWorld * vec4(position, 1.0)).xyz, 1.0);
    normal = mat3(viewToWorld) * normal;
    float size = length(normal);
    normalAov = vec4(size > 0.0 ? -normal / size : vec3(0.0), -position.z);
#ifdef FAR_DEPTH
    gl_FragDepth = -position.z * depthScale;
#endif
}
