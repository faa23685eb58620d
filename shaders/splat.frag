// A ball, seen as if from straight ahead.
flat in float splat_depth;
flat in float splat_radius;
flat in float splat_hash;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_surface;

void main() {
    vec2 d = gl_PointCoord * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    float towards = 1.0 - dot(d, d);
    if (towards < 0.0) discard;
    // A grain is no ball: each leans its own way.
    vec3 lean = 2.0 * fract(splat_hash * vec3(17.31, 131.7, 1093.3)) - 1.0;
    vec3 normal = normalize(basis * vec3(d, -sqrt(towards)) + 0.7 * lean);
    out_depth = splat_depth - splat_radius * sqrt(towards);
    out_surface = surface_of(normal);
    gl_FragDepth = buffer_depth(out_depth);
}
