// Triangles tessellated in advance, the baseline for measurements of tessellation. The outputs are
// those of the evaluation stages, so that the fragment stages of both methods can be used.

layout(location = 0) in vec4 vertexPosition; // world space; w holds u
layout(location = 1) in vec4 vertexNormal;   // world space; w holds v
#ifdef AOV
layout(location = 2) in uint vertexPatch;
#endif

layout(location = 2) uniform mat4 viewMatrix;
layout(location = 3) uniform mat4 projectionMatrix;

layout(location = 0) out vec3 passNormal;
layout(location = 1) out vec2 passTessCoord;
layout(location = 2) out vec4 position;
#ifdef AOV
layout(location = 3) flat out uint passPatch;
#else
layout(location = 4) out vec2 passUVCoord; // read by the thesis' fragment stage
#endif

void main()
{
    vec3 normal = mat3(viewMatrix) * vertexNormal.xyz;
    float size = dot(normal, normal);
    passNormal = size > 0.0 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
    passTessCoord = vec2(vertexPosition.w, vertexNormal.w);
    position = viewMatrix * vec4(vertexPosition.xyz, 1.0);
    gl_Position = projectionMatrix * position;
#ifdef AOV
    passPatch = vertexPatch;
#else
    passUVCoord = passTessCoord;
#endif
}
