uniform sampler2D relief;          // slopes and height, in standard deviations

// Slopes and height of the ground, in standard deviations: fine, and nine times coarser across it, so that no
// eye sees the tiles repeat. What is smaller than a sample fades.
vec3 relief_at(vec2 position, float sample_width) {
    const float tile = 160.0;  // [spacings]
    vec2 at = position / (tile * spacing);
    float level = log2(max(sample_width / (tile * spacing) * float(textureSize(relief, 0).x), 1e-6));
    vec3 fine = textureLod(relief, at, level).xyz;
    vec3 coarse = textureLod(relief, mat2(0.09, 0.06, -0.06, 0.09) * at, level - 3.2).xyz;
    return 3.0 * (fine + coarse - 1.0);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    vec3 ray = ray_through(gl_FragCoord.xy);
    vec3 position = eye + depth * ray;
    vec3 normal = normalize(texelFetch(surface, at, 0).xyz * 2.0 - 1.0);
    float sample_width = depth * sample_tan / sqrt(max(abs(dot(normalize(ray), normal)), 0.01));
    vec3 uneven = relief_at(position.xz, sample_width);
    vec3 bumpy = normalize(normal - 0.05 * vec3(uneven.x, 0.0, uneven.y));
    vec3 colour = matt(vec3(0.66, 0.67, 0.685) * (1.0 + 0.02 * uneven.z), position, bumpy);
    out_light = seen_through_air(colour, depth, ray);
}
