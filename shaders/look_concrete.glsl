Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 cloud = noise_at(at, 1.9, width), blotch = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.45, width);
    vec3 sand = noise_at(mat2(0.96, 0.28, -0.28, 0.96) * at, 0.087, 0.6 * width);
    float hole = smoothstep(2.2, 3.0, noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 0.13, width).z + 0.5 * blotch.z);
    vec3 colour = vec3(0.255, 0.245, 0.235) * (1.0 + 0.05 * cloud.z + 0.04 * blotch.z + 0.055 * sand.z);
    colour *= 1.0 - 0.35 * hole;
    vec2 slope = 0.02 * blotch.xy + 0.05 * sand.xy;
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), 0.0, 1.0, 0.0);
}
