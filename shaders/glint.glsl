vec3 hash_of(vec3 cell) {
    vec3 p = fract(cell * vec3(0.1031, 0.1030, 0.0973));
    p += dot(p, p.yxz + 33.33);
    return fract((p.xxy + p.yxx) * p.zyx);
}

// Crystals that mirror the sun: one facet in every cell of space, so that they rest with the snow whatever the camera
// does. A cell is at least three samples of that width wide.
float glint(vec3 position, vec3 normal, vec3 ray, float width) {
    float cell = exp2(ceil(log2(max(3.0 * width, 0.25 * spacing))));
    vec3 at = position / cell, h = hash_of(floor(at)), half_way = normalize(to_sun - normalize(ray));
    float mirrored = smoothstep(0.9965, 0.9990, dot(normalize(normal + 1.6 * h - 0.8), half_way));
    return mirrored * (0.2 + 0.8 * fract(7.0 * h.x)) * fading(0.1, 0.45, length(fract(at) - 0.5));
}
