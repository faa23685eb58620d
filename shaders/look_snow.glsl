// Drifts and hollows without what is finer, and the grain: snow is smooth in between.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 drift = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 1700.0 * spacing, max(width, 60.0 * spacing));
    vec3 fine = noise_at(at, 310.0 * spacing, max(width, 6.0 * spacing));
    vec3 grain = noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 61.0 * spacing, width);
    float near = 1.0 / (1.0 + width / (12.0 * spacing));  // from afar one sees crests alone, which are lit alike
    vec3 slope = near * (0.10 * drift + 0.04 * fine + 0.10 * grain);
    return Matter(vec3(0.92, 0.925, 0.935) * (1.0 + near * (0.01 * fine.z + 0.02 * grain.z)),
                  normalize(n - slope.x * u - slope.y * v), 0.0, 0.0);
}
