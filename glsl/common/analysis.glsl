// Stripes and colours by which the shape of surfaces is judged. Keep in step with src/reference/analysis.rs.
//
// All vectors are in view space. Normals need not have unit length.

// Homogeneous: the eye at the origin, or the direction of the z axis in an orthographic view.
layout(location = 44) uniform vec4 eye;
// The direction of stripes or of the pull; the number of stripes, or 1 over the end of the scale.
layout(location = 45) uniform vec4 analysis;
layout(location = 47) uniform int curvatureKind; // 0: Gaussian, 1: mean, 2: largest

const vec3 DARK = vec3(0.1);
const vec3 BRIGHT = vec3(0.95);

// The colour of a value from -1 to 1 on a scale of three colours.
vec3 onScale(float value, vec3 low, vec3 middle, vec3 high)
{
    return mix(middle, value < 0.0 ? low : high, min(abs(value), 1.0));
}

// The colour of a stripe, at a share from 0 to 1 of all stripes.
vec3 stripe(float share)
{
    float number = clamp(floor(share * analysis.w), 0.0, analysis.w - 1.0);
    return mod(number, 2.0) == 0.0 ? DARK : BRIGHT;
}

vec3 towardsEye(vec3 position)
{
    return normalize(eye.xyz - eye.w * position);
}

vec3 zebra(vec3 position, vec3 normal)
{
    vec3 toEye = towardsEye(position);
    float size = max(dot(normal, normal), 1e-37);
    vec3 mirrored = 2.0 * dot(normal, toEye) / size * normal - toEye;
    return stripe(0.5 + 0.5 * dot(mirrored, analysis.xyz));
}

vec3 isophotes(vec3 normal)
{
    float size = max(dot(normal, normal), 1e-37);
    return stripe(abs(dot(normal, analysis.xyz)) * inversesqrt(size));
}

vec3 draft(vec3 position, vec3 normal)
{
    normal *= dot(normal, towardsEye(position)) < 0.0 ? -1.0 : 1.0;
    float along = dot(normal, analysis.xyz), across = length(cross(normal, analysis.xyz));
    float angle = along == 0.0 ? 0.0 : atan(along, across);
    return onScale(angle * analysis.w, vec3(0.8, 0.15, 0.15), vec3(0.98, 0.88, 0.4), vec3(0.15, 0.6, 0.25));
}

// `values`: the Gaussian curvature, the mean curvature, which is above 0 where the surface bends towards the normal, and
// half of the difference of the principal curvatures.
vec3 curvatureColor(vec3 values, vec3 position, vec3 normal)
{
    float mean = values.y * (dot(normal, towardsEye(position)) < 0.0 ? -1.0 : 1.0);
    float largest = mean + (mean < 0.0 ? -values.z : values.z);
    float value = curvatureKind == 0 ? values.x : curvatureKind == 1 ? mean : largest;
    return onScale(value * analysis.w, vec3(0.23, 0.3, 0.75), vec3(0.87), vec3(0.71, 0.02, 0.15));
}
