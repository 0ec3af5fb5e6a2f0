// The same triangles as a tessellated patch, computed beforehand: the floor that tessellation is
// measured against. It hands the thesis' fragment stage what its evaluation stage would.

layout(location = 0) in vec4 vertexPosition; // model space; w holds u
layout(location = 1) in vec4 vertexNormal;   // model space; w holds v

layout(location = 1) uniform mat4 modelMatrix;
layout(location = 2) uniform mat4 viewMatrix;
layout(location = 3) uniform mat4 projectionMatrix;

out vec3 passNormal;
out vec2 passTessCoord;
out vec2 passUVCoord;
out vec4 position;

void main()
{
    passNormal = normalize(mat3(viewMatrix) * mat3(modelMatrix) * vertexNormal.xyz);
    passTessCoord = vec2(vertexPosition.w, vertexNormal.w);
    passUVCoord = passTessCoord;
    position = viewMatrix * (modelMatrix * vec4(vertexPosition.xyz, 1.0));
    gl_Position = projectionMatrix * position;
}
