// A lump of grains, seen as if from straight ahead: a ball with an uneven outline and face.
uniform sampler2D relief;          // slopes and height, in standard deviations

flat in float splat_depth;
flat in float splat_radius;
flat in float splat_hash;
flat in float splat_value;
flat in float splat_size;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_surface;
layout(location = 2) out float out_value;

void main() {
    vec2 d = gl_PointCoord * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    // A small one is bent, each its own way; a wide one has a face, into which that grows.
    vec4 bend = 4.0 * fract(splat_hash * vec4(37.7, 311.3, 733.1, 171.9)) - 2.0;
    vec3 uneven = vec3(bend.x * d + bend.y * d.yx * vec2(-1.0, 1.0), dot(bend.zw, vec2(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y)));
    if (faces == 1) {  // a constant
        float share = smoothstep(12.0, 24.0, splat_size);
        float level = log2(max(0.22 * float(textureSize(relief, 0).x) / splat_size, 1.0));
        uneven = mix(uneven, textureLod(relief, 0.11 * d + fract(splat_hash * vec2(37.7, 311.3)), level).xyz * 6.0 - 3.0, share);
    }
    float towards = 1.0 - dot(d, d) * (1.15 + 0.30 * uneven.z);
    if (towards < 0.0) discard;
    // A grain is no ball: each leans its own way; where it is wide, its face is uneven instead.
    float narrow = clamp(8.0 / splat_size, 0.15, 1.0);
    vec3 lean = 2.0 * fract(splat_hash * vec3(17.31, 131.7, 1093.3)) - 1.0;
    vec3 normal = normalize(basis * vec3(narrow * d - (0.55 - 0.3 * narrow) * uneven.xy, -sqrt(towards)) + 0.6 * narrow * lean);
    out_depth = splat_depth - splat_radius * (sqrt(towards) + 0.12 * uneven.z);
    out_surface = surface_of(normal);
    out_value = splat_value;
    gl_FragDepth = buffer_depth(out_depth);
}
