layout(location = 0) in vec3 center;
layout(location = 1) in float radius;
uniform mat4 shadow_matrix;
uniform float texel;  // [m]
uniform float max_point_size;

void main() {
    gl_Position = shadow_matrix * vec4(center, 1.0);
    gl_PointSize = clamp(1.772 * radius / texel, 1.5, max_point_size);
}
