// Instance 0 is the particle; the others are smaller children about it, the same in every frame, which grow
// out of it as the camera comes near.
layout(location = 0) in vec3 center;
layout(location = 1) in float radius;
layout(location = 2) in float hash;
layout(location = 3) in float value;
uniform float max_point_size;
uniform float grown_from, grown_to;  // radius at which children begin to show, and have grown up [samples]

flat out float splat_depth;
flat out float splat_radius;
flat out float splat_hash;
flat out float splat_value;
flat out float splat_size;    // [samples]

void main() {
    vec3 at = center;
    float r = radius;
    float sample_width = max(dot(center - eye, basis[2]), near_depth) * sample_tan;
    float grown = smoothstep(grown_from, grown_to, r / sample_width);
    splat_hash = hash;
    if (faces == 1 && gl_InstanceID > 0) {  // a constant
        vec3 h = fract(hash * vec3(91.7, 613.3, 171.9) + float(gl_InstanceID) * vec3(0.6180, 0.4142, 0.7321));
        float turn = 6.2832 * h.x, height = 2.0 * h.y - 1.0;
        vec3 direction = vec3(sqrt(1.0 - height * height) * vec2(cos(turn), sin(turn)), height);
        at += 0.92 * r * direction;
        r *= grown * (0.25 + 0.30 * h.z);
        splat_hash = fract(hash + 0.381966 * float(gl_InstanceID));
    } else {
        r *= 1.0 - 0.12 * grown;
    }
    gl_Position = r > 0.0 ? projection * vec4(at, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    splat_depth = dot(at - eye, basis[2]);
    sample_width = max(splat_depth, near_depth) * sample_tan;
    splat_size = clamp(2.0 * r / sample_width, 1.0, max_point_size);
    gl_PointSize = splat_size;
    splat_radius = 0.5 * splat_size * sample_width;
    splat_value = value;
}
