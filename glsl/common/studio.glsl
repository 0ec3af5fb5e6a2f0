// The studio: lamps that move with the camera, and a hemisphere. Keep in step with src/reference/shading.rs.
//
// Light is added up in linear values; the result is sRGB. All vectors are in view space. No sum of the lamps exceeds 1,
// so nothing is clipped.

// Homogeneous: the eye at the origin, or the direction of the z axis in an orthographic view.
layout(location = 44) uniform vec4 eye;

const vec3 KEY = normalize(vec3(-2.0, 3.0, 3.0));
const vec3 FILL = normalize(vec3(3.0, 0.5, 2.0));
const vec3 RIM = normalize(vec3(1.0, 2.0, -1.5));

// Zero stays zero.
vec3 unit(vec3 vector)
{
    return vector * inversesqrt(max(dot(vector, vector), 1e-37));
}

// Upright on the triangle that a pixel shows, towards the eye; 0 on a line. It has derivatives: not behind a discard.
vec3 uprightAt(vec3 position)
{
    vec3 right = unit(dFdx(position)), up = dFdy(position);
    vec3 upright = cross(right, up);
    return dot(upright, upright) > 1e-6 * dot(up, up) ? upright : vec3(0.0);
}

// Both sides are lit alike: a normal that points behind the triangle is turned around. Its angle to the eye would not
// do: between the vertices of triangles, normals point away from the eye before the silhouette.
vec3 lit(vec3 linearColor, vec3 position, vec3 normal, vec3 upright)
{
    vec3 toEye = normalize(eye.xyz - eye.w * position);
    normal = unit(normal);
    normal *= dot(normal, upright == vec3(0.0) ? toEye : upright) < 0.0 ? -1.0 : 1.0;
    float light = 0.13 + 0.06 * normal.y;
    light += 0.74 * max(0.8 * dot(normal, KEY) + 0.2, 0.0);
    light += 0.12 * max(dot(normal, FILL), 0.0) + 0.12 * max(dot(normal, RIM), 0.0);
    float gloss = max(dot(normal, normalize(KEY + toEye)), 0.0);
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    return srgbOf(mix(light * linearColor, vec3(1.0), 0.3 * gloss));
}
