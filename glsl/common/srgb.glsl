// sRGB, by the standard's exact formula (IEC 61966-2-1). Keep in step with src/reference/shading.rs.

vec3 linearOf(vec3 srgb)
{
    return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

vec3 srgbOf(vec3 light)
{
    return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308)));
}
