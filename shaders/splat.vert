// Instance 0 is the particle; the others are smaller children about it, the same in every frame, which grow
// out of it as the camera comes near.
layout(location = 0) in vec3 center;
layout(location = 1) in float radius;
layout(location = 2) in float hash;
layout(location = 3) in float value;
uniform float max_point_size;
uniform float edge;                  // samples along a pixel's edge
uniform float children;              // the last one of a broken number is smaller
uniform float grown_from, grown_to;  // radius at which children begin to show, and have grown up [samples]

flat out float splat_depth;
flat out float splat_radius;
flat out float splat_hash;
flat out float splat_value;
flat out float splat_size;    // [samples]
flat out vec4 splat_bend;     // how its face turns with the place on it, and how its outline bends
flat out vec3 splat_lean;
flat out float splat_face;    // share of its own shape that has given way to grain

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
        at += (1.15 - 0.45 * h.z) * r * direction;
        r *= grown * min(children + 1.0 - float(gl_InstanceID), 1.0) * (0.20 + 0.42 * h.z * h.z);
        splat_hash = fract(hash + 0.381966 * float(gl_InstanceID));
    } else {
        r *= 1.0 - 0.25 * grown * min(0.25 * children, 1.0);  // they fill what it leaves
    }
    gl_Position = r > 0.0 ? projection * vec4(at, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    splat_depth = dot(at - eye, basis[2]);
    sample_width = max(splat_depth, near_depth) * sample_tan;
    splat_size = clamp(2.0 * r / sample_width, 1.0, max_point_size);
    gl_PointSize = splat_size;
    splat_radius = 0.5 * splat_size * sample_width;
    splat_value = value;
    // A small one is bent, each its own way; a wide one has a face, into which that grows. A grain is no ball: each leans
    // its own way, too.
    splat_face = faces == 1 ? smoothstep(max(2.0 * grown_from, 4.8 * edge), max(3.0 * grown_from, 7.2 * edge), splat_size) : 0.0;
    vec4 bend = (1.0 - splat_face) * (4.0 * fract(splat_hash * vec4(37.7, 311.3, 733.1, 171.9)) - 2.0);
    float narrow = clamp(8.0 / splat_size, 0.15, 1.0), steep = 0.55 - 0.3 * narrow;
    splat_bend = vec4(narrow - steep * bend.x, steep * bend.y, bend.zw);
    splat_bend.xy *= 1.0 - 0.7 * splat_face;
    splat_lean = (0.6 - 0.36 * splat_face) * narrow * (2.0 * fract(splat_hash * vec3(17.31, 131.7, 1093.3)) - 1.0);
}
