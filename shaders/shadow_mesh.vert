layout(location = 0) in vec3 position;
uniform mat4 shadow_matrix;
void main() { gl_Position = shadow_matrix * vec4(position, 1.0); }
