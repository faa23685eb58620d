layout(location = 0) in vec3 center;
layout(location = 1) in float radius;
layout(location = 2) in float hash;
uniform float max_point_size;

flat out float splat_depth;
flat out float splat_radius;
flat out float splat_hash;

void main() {
    gl_Position = projection * vec4(center, 1.0);
    splat_depth = dot(center - eye, basis[2]);
    float sample_width = max(splat_depth, near_depth) * sample_tan;
    float size = clamp(2.0 * radius / sample_width, 1.0, max_point_size);
    gl_PointSize = size;
    splat_radius = 0.5 * size * sample_width;
    splat_hash = hash;
}
