// What a pixel shows, as numbers instead of a colour; trims are decided at the pixel's centre.

in vec2 passTessCoord;
in vec4 position; // view space
flat in uint passPatch;

layout(location = 24) uniform mat4 viewToWorld;

layout(location = 0) out vec4 uvAov;       // u, v, patch, 1
layout(location = 1) out vec4 positionAov; // world space, and 1
layout(location = 2) out vec4 normalAov;   // world space, Su × Sv; and the depth along the view axis

void main()
{
#ifdef TRIMMED
    if (cut(passTessCoord))
        discard;
#endif
    uvAov = vec4(passTessCoord, float(passPatch), 1.0);
    positionAov = vec4((viewToWorld * vec4(position.xyz, 1.0)).xyz, 1.0);
    vec3 normal = mat3(viewToWorld) * normalAt(passTessCoord);
    float size = length(normal);
    normalAov = vec4(size > 0.0 ? -normal / size : vec3(0.0), -position.z);
}
