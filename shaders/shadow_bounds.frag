// The same of `edge`² blocks, and of those up to `reach` blocks away; beyond the map all is lit.
uniform sampler2D blocks;
uniform int edge;
uniform int reach;
uniform bool last_step;            // rounds outwards, to ten bits

out vec4 out_bounds;

const float step_of_10_bits = 1.0 / 1023.0;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * edge - reach, last = textureSize(blocks, 0) - 1;
    vec3 bounds = vec3(1.0, 0.0, 0.0);
    for (int j = 0; j < edge + 2 * reach; ++j)
        for (int i = 0; i < edge + 2 * reach; ++i) {
            ivec2 at = first + ivec2(i, j), inside = clamp(at, ivec2(0), last);
            vec3 block = texelFetch(blocks, inside, 0).xyz;
            bounds = vec3(min(bounds.x, block.x), max(bounds.y, at == inside ? block.y : 1.0), max(bounds.z, block.z));
        }
    out_bounds = last_step ? vec4(bounds.x < 1.0 ? bounds.x - step_of_10_bits : 1.0, bounds.y + step_of_10_bits, ceil(min(bounds.z, 1.0)), 1.0)
                           : vec4(bounds, 0.0);
}
