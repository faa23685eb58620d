// Planks; what is round is a log, of one piece.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    float plank = axis.w > 0.0 ? 1e3 : 0.14;
    at.y += 0.5 * plank;
    float row = floor(at.y / plank), shift = 1.9 * hash_at(vec2(row, 3.0));
    vec3 cell = cell_at(at + vec2(shift, 0.0), vec2(2.4, plank));
    float own = hash_at(cell.yz);
    vec2 along = vec2(0.07, 1.0) * at + vec2(own * 7.0, own * 3.0);
    vec3 warp = noise_at(along, 1.3, width), fibre = noise_at(vec2(0.02, 1.0) * at + own, 0.055, 2.0 * width);
    float rings = 0.5 + 0.5 * sin(90.0 * along.y + 5.0 * warp.z);
    rings = mix(0.5, rings, clamp(1.4 - 60.0 * width, 0.0, 1.0));
    vec3 colour = mix(vec3(0.36, 0.235, 0.135), vec3(0.235, 0.140, 0.075), 0.65 * rings);
    colour *= (0.80 + 0.40 * own) * (1.0 + 0.09 * fibre.z + 0.05 * warp.z);
    float gap = smooth_edge(cell.x, 0.0016, width + 0.001);
    return Matter(colour * mix(0.22, 1.0, gap),
                  normalize(n - (0.03 * fibre.y) * v), 0.02 * gap, 0.55);
}
