Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 brush = noise_at(vec2(0.02, 1.0) * at, 0.05, 3.0 * width), wear = noise_at(at, 0.8, width);
    vec3 colour = vec3(0.30, 0.31, 0.325) * (1.0 + 0.05 * brush.z + 0.05 * wear.z);
    vec2 slope = vec2(0.003 * wear.x, 0.025 * brush.y + 0.003 * wear.y);
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), 0.45, 0.35 + 0.03 * wear.z, 0.0);
}
