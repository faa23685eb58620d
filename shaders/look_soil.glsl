Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 broad = noise_at(at, 2.3, width), clod = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.55, width);
    vec3 crumb = noise_at(at, 0.11, width);
    vec2 slope = 0.10 * broad.xy + 0.34 * clod.xy + 0.30 * crumb.xy;
    float height = 0.5 * clod.z + 0.5 * crumb.z;
    vec3 colour = mix(vec3(0.085, 0.060, 0.042), vec3(0.22, 0.165, 0.115), smoothstep(-2.0, 2.0, height));
    colour *= 1.0 + 0.12 * broad.z;
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), 0.0, 1.0);
}
