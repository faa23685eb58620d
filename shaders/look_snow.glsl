Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 drift = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 900.0 * spacing, width);
    vec3 fine = noise_at(at, 150.0 * spacing, width);
    vec3 grain = noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 26.0 * spacing, width);
    vec3 slope = 0.07 * drift + 0.04 * fine + 0.11 * grain;
    return Matter(vec3(0.86, 0.87, 0.885) * (1.0 + 0.02 * fine.z + 0.035 * grain.z),
                  normalize(n - slope.x * u - slope.y * v), 0.0, 0.0);
}
