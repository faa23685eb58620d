layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
out vec3 world_position;
out vec3 world_normal;
out float depth;

void main() {
    gl_Position = projection * vec4(position, 1.0);
    world_position = position;
    world_normal = normal;
    depth = dot(position - eye, basis[2]);
}
