vec3 hash_of(vec3 cell) {
    vec3 p = fract(cell * vec3(0.1031, 0.1030, 0.0973));
    p += dot(p, p.yxz + 33.33);
    return fract((p.xxy + p.yxx) * p.zyx);
}

// Crystals that mirror the sun: one facet in every cell of space, so that they rest with the snow whatever the camera
// does. A cell is at least three samples of that width wide; from afar, where a particle has less than three, there are
// none. The depth in a cell at which a face cuts through it does not matter: level ground would have all or none.
float glint(vec3 position, vec3 normal, vec3 ray, float width) {
    float cell = exp2(ceil(log2(max(3.0 * width, 0.25 * spacing))));
    vec3 at = position / cell + 0.5, h = hash_of(floor(at)), aside = fract(at) - 0.5;
    float off = length(aside - 0.8 * dot(aside, normal) * normal), near = fading(0.18, 0.35, width / spacing);
    float mirrored = smoothstep(0.9965, 0.9990, dot(normalize(normal + 1.6 * h - 0.8), normalize(to_sun - normalize(ray))));
    return near * mirrored * (0.2 + 0.8 * fract(7.0 * h.x)) * fading(0.05, 0.34, off);
}
