// Listings 7 and 13: Phong's model with two lights, then the trims. Keep in step with
// src/reference/shading.rs.
//
// All vectors are in view space, where the eye is the origin that the listing takes it for. The
// lights stand above and below the world's origin, whose axes are the columns of viewMatrix.

in vec3 passNormal;
in vec4 position;
in vec2 passTessCoord;
in vec2 passUVCoord;

layout(binding = 0) uniform sampler2D colortexture;

out vec4 fragmentColor;

#ifdef PHONG
layout(location = 2) uniform mat4 viewMatrix;

vec3 lit(vec3 diffuseColor)
{
    vec3 lightPosition = viewMatrix[3].xyz + 10.0 * viewMatrix[1].xyz;
    vec3 lightPosition2 = viewMatrix[3].xyz - 10.0 * viewMatrix[1].xyz;
    vec3 lightVector = normalize(lightPosition - position.xyz);
    vec3 lightVector2 = normalize(lightPosition2 - position.xyz);

    vec3 eye = normalize(-position.xyz);
    vec3 reflection = normalize(reflect(-lightVector, passNormal));
    vec3 reflection2 = normalize(reflect(-lightVector2, passNormal));

    float phi = max(dot(passNormal, lightVector), 0.0);
    float psi = pow(max(dot(reflection, eye), 0.0), 150.0);
    float phi2 = max(dot(passNormal, lightVector2), 0.0);
    float psi2 = pow(max(dot(reflection2, eye), 0.0), 150.0);

    vec3 ambientColor = vec3(0.1);
    vec3 specularColor = vec3(1.0);
    return diffuseColor * ambientColor + phi * diffuseColor + psi * specularColor
        + phi2 * diffuseColor + psi2 * specularColor;
}
#endif

void main()
{
    // Sampled before anything is discarded: the texture's derivatives need all neighbours.
    vec3 diffuseColor = texture(colortexture, passUVCoord).rgb;
#ifdef TRIMMED
    if (cut(passTessCoord))
        discard;
#endif
#if defined(PHONG)
    fragmentColor = vec4(lit(diffuseColor), 1.0);
#elif defined(NORMALS)
    float size = length(passNormal);
    fragmentColor = vec4(0.5 * (size > 0.0 ? passNormal / size : vec3(0.0)) + 0.5, 1.0);
#else
    fragmentColor = vec4(diffuseColor, 1.0);
#endif
}
