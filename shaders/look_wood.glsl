// Planks; what is round is a log, of one piece, with rings at its ends.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    bool whole = axis.w > 0.0, end = cut_across(n);
    float plank = whole ? 1e3 : 0.14;
    at.y += 0.5 * plank;
    float row = floor(at.y / plank), shift = whole ? 500.0 : 1.9 * hash_at(vec2(row, 3.0));
    vec3 cell = cell_at(at + vec2(shift, 0.0), vec2(whole ? 1e3 : 2.4, plank));
    float own = hash_at(cell.yz);
    vec2 from_pith = at - vec2(0.0, 0.5 * plank) - vec2(dot(axis.xyz, u), dot(axis.xyz, v)) - 0.06 * axis.w;
    vec2 along = end ? from_pith : vec2(0.07, 1.0) * at + vec2(own * 7.0, own * 3.0);
    vec3 warp = noise_at(along, end ? 10.0 * axis.w : 1.3, width);
    vec3 fibre = noise_at(end ? at : vec2(0.02, 1.0) * at + own, 0.055, width);
    vec3 vein = noise_at(end ? at.yx : vec2(0.05, 1.0) * at + own, 0.24, width);
    float split = end ? 0.0 : smoothstep(1.7, 2.6, vein.z + 0.5 * fibre.z);  // dried out, along the fibres
    float phase = end ? 300.0 * length(from_pith) + 1.5 * warp.z : 90.0 * along.y + 5.0 * warp.z;
    float rings = 0.5 + 0.5 * sin(phase);
    if (end) rings *= rings * rings;  // summers' wood is wide, winters' thin and dark
    rings = mix(0.5, rings, clamp(1.4 - (end ? 180.0 : 60.0) * width, 0.0, 1.0));
    vec3 colour = mix(vec3(0.36, 0.235, 0.135), vec3(0.235, 0.140, 0.075), 0.65 * rings);
    colour *= (0.80 + 0.40 * own) * (1.0 + 0.12 * fibre.z + 0.08 * vein.z + 0.05 * warp.z) * (1.0 - 0.55 * split);
    float gap = smooth_edge(cell.x, 0.0016, width + 0.001);
    return Matter(colour * mix(0.22, 1.0, gap),
                  normalize(n - (0.05 * fibre.y + 0.06 * vein.y) * v), 0.02 * gap, 0.55);
}
