Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 cell = cell_at(at, vec2(0.25));
    float own = hash_at(cell.yz), body = smooth_edge(cell.x, 0.0025, width + 0.0015);
    vec3 stain = noise_at(at + own, 0.9, width), speck = noise_at(at, 0.12, width);
    vec3 colour = mix(vec3(0.33, 0.34, 0.35), vec3(0.42, 0.425, 0.42), own) * (1.0 + 0.05 * stain.z + 0.04 * speck.z);
    vec2 lean = 0.012 * (vec2(own, hash_at(cell.zy + 7.0)) - 0.5) + 0.004 * stain.xy;
    return Matter(mix(vec3(0.17, 0.165, 0.16), colour, body), normalize(n - lean.x * u - lean.y * v),
                  0.04 * body, 0.12, 0.0);
}
