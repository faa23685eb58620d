// A lump of grains, seen as if from straight ahead: a ball with an uneven outline and face.
uniform sampler2D relief;          // slopes and height, in standard deviations

flat in float splat_depth;
flat in float splat_radius;
flat in float splat_hash;
flat in float splat_value;
flat in float splat_size;
flat in vec4 splat_bend;
flat in vec3 splat_lean;
flat in float splat_face;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_surface;
layout(location = 2) out float out_value;

void main() {
    vec2 d = gl_PointCoord * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    float height = dot(splat_bend.zw, vec2(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y));
    vec2 tilt = splat_bend.x * d + splat_bend.y * d.yx * vec2(1.0, -1.0);
    if (faces == 1) {  // a constant
        float level = log2(max(0.22 * float(textureSize(relief, 0).x) / splat_size, 1.0));
        vec3 uneven = textureLod(relief, 0.11 * d + fract(splat_hash * vec2(37.7, 311.3)), level).xyz * 6.0 - 3.0;
        tilt -= 0.55 * splat_face * uneven.xy;
        height += splat_face * uneven.z;
    }
    float towards = 1.0 - dot(d, d) * (1.25 + 0.55 * height);
    if (towards < 0.0) discard;
    float ahead = sqrt(towards);
    vec3 normal = normalize(basis * vec3(tilt, -ahead) + splat_lean);
    out_depth = splat_depth - splat_radius * (ahead + 0.12 * height);
    out_surface = surface_of(normal);
    out_value = splat_value;
    gl_FragDepth = buffer_depth(out_depth);
}
