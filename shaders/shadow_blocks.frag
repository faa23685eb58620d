// Of a block of the shadow map: the least and the largest depth, and the thickest spray.
uniform sampler2D shadow_depths;
uniform sampler2D spray_shadow;
uniform int blocks_across;

out vec4 out_bounds;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    int edge = textureSize(shadow_depths, 0).x / blocks_across;
    vec3 bounds = vec3(1.0, 0.0, 0.0);
    for (int j = 0; j < edge; ++j)
        for (int i = 0; i < edge; ++i) {
            float depth = texelFetch(shadow_depths, at * edge + ivec2(i, j), 0).r;
            bounds.xy = vec2(min(bounds.x, depth), max(bounds.y, depth));
        }
    edge = textureSize(spray_shadow, 0).x / blocks_across;
    for (int j = 0; j < edge; ++j)
        for (int i = 0; i < edge; ++i)
            bounds.z = max(bounds.z, texelFetch(spray_shadow, at * edge + ivec2(i, j), 0).r);
    out_bounds = vec4(bounds, 0.0);
}
