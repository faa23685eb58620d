layout(location = 0) in vec3 center;
layout(location = 6) in float puff_radius;  // [m]
layout(location = 7) in float powder;       // 0 to 1
uniform mat4 shadow_matrix;
uniform float texel;      // [m]
uniform float max_point_size;

flat out float thickness; // optical depth in the middle

void main() {
    gl_Position = powder > 0.01 ? shadow_matrix * vec4(center, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    float radius = 1.6 * puff_radius / texel, drawn = clamp(radius, 2.0, 0.5 * max_point_size);
    gl_PointSize = 2.0 * drawn;
    thickness = 0.22 * powder * radius * radius / (drawn * drawn);
}
