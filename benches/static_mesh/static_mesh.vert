// The same triangles as a tessellated patch, computed beforehand: the floor that tessellation is
// measured against. It hands the fragment stage what an evaluation stage would.

layout(location = 0) in vec4 vertexPosition; // model space; w holds u
layout(location = 1) in vec4 vertexNormal;   // model space; w holds v

layout(location = 1) uniform mat4 modelMatrix;
layout(location = 2) uniform mat4 viewMatrix;
layout(location = 3) uniform mat4 projectionMatrix;

layout(location = 0) out vec3 passNormal;
layout(location = 1) out vec2 passTessCoord;
layout(location = 2) out vec4 position;
layout(location = 4) out vec2 passUVCoord;

void main()
{
    passNormal = normalize(mat3(viewMatrix) * mat3(modelMatrix) * vertexNormal.xyz);
    passTessCoord = vec2(vertexPosition.w, vertexNormal.w);
    passUVCoord = passTessCoord;
    position = viewMatrix * (modelMatrix * vec4(vertexPosition.xyz, 1.0));
    gl_Position = projectionMatrix * position;
}
