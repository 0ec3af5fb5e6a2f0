// Listing 7: Phong's model with two lights. Keep in step with src/reference/shading.rs.
//
// All vectors are in view space: the listing assumes the eye at the origin.

layout(location = 33) uniform vec3 lightPosition;
layout(location = 34) uniform vec3 lightPosition2;

vec3 lit(vec3 diffuseColor, vec3 position, vec3 normal)
{
    vec3 lightVector = normalize(lightPosition - position);
    vec3 lightVector2 = normalize(lightPosition2 - position);

    vec3 eye = normalize(-position);
    vec3 reflection = normalize(reflect(-lightVector, normal));
    vec3 reflection2 = normalize(reflect(-lightVector2, normal));

    float phi = max(dot(normal, lightVector), 0.0);
    float psi = pow(max(dot(reflection, eye), 0.0), 150.0);
    float phi2 = max(dot(normal, lightVector2), 0.0);
    float psi2 = pow(max(dot(reflection2, eye), 0.0), 150.0);

    vec3 ambientColor = vec3(0.1);
    vec3 specularColor = vec3(1.0);
    return diffuseColor * ambientColor + phi * diffuseColor + psi * specularColor
        + phi2 * diffuseColor + psi2 * specularColor;
}
