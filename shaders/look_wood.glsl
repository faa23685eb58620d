// Bark: plates along what is round, with furrows between them.
Matter bark(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 plate = noise_at(vec2(0.16, 1.0) * at, 0.23, width), rough = noise_at(vec2(0.35, 1.0) * at, 0.06, width);
    vec3 moss = noise_at(at, 1.1, width);
    float ridge = plate.z + 0.7 * rough.z, furrow = fading(0.0, 0.7, abs(ridge));
    vec3 colour = mix(vec3(0.235, 0.175, 0.125), vec3(0.26, 0.235, 0.205), smoothstep(-1.0, 1.5, moss.z));
    colour = mix(colour * (1.0 + 0.15 * rough.z), vec3(0.075, 0.056, 0.042), 0.8 * furrow);
    vec2 slope = 0.22 * sign(ridge) * plate.xy * vec2(0.16, 1.0) + 0.16 * rough.xy;
    return Matter(colour, normalize(n + slope.x * u + slope.y * v), 0.0, 1.0, 0.0);
}

// Rings of what is cut across: summers' wood is wide, winters' thin and dark.
Matter end_grain(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec2 from_middle = at - vec2(dot(axis.xyz, u), dot(axis.xyz, v)), from_pith = from_middle - 0.06 * axis.w;
    vec3 warp = noise_at(from_pith, 10.0 * axis.w, width), fibre = noise_at(at, 0.055, width);
    float rings = 0.5 + 0.5 * sin(300.0 * length(from_pith) + 1.5 * warp.z);
    rings = mix(0.5, rings * rings * rings, clamp(1.4 - 180.0 * width, 0.0, 1.0));
    float rim = smoothstep(0.92, 0.95, length(from_middle) / axis.w + 0.01 * warp.z);
    vec3 colour = mix(vec3(0.36, 0.235, 0.135), vec3(0.235, 0.140, 0.075), 0.65 * rings);
    colour = mix(colour * (1.0 + 0.10 * fibre.z + 0.06 * warp.z), vec3(0.10, 0.075, 0.055), rim);
    return Matter(colour, normalize(n - 0.03 * fibre.y * v), 0.0, 1.0, 0.0);
}

Matter planks(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    const float plank = 0.14;
    at.y += 0.5 * plank;
    vec3 cell = cell_at(at + vec2(1.9 * hash_at(vec2(floor(at.y / plank), 3.0)), 0.0), vec2(2.4, plank));
    float own = hash_at(cell.yz);
    vec2 along = vec2(0.07, 1.0) * at + vec2(own * 7.0, own * 3.0);
    vec3 warp = noise_at(along, 1.3, width);
    vec3 fibre = noise_at(vec2(0.02, 1.0) * at + own, 0.055, width), vein = noise_at(vec2(0.05, 1.0) * at + own, 0.24, width);
    float split = smoothstep(1.7, 2.6, vein.z + 0.5 * fibre.z);  // dried out, along the fibres
    float rings = mix(0.5, 0.5 + 0.5 * sin(90.0 * along.y + 5.0 * warp.z), clamp(1.4 - 60.0 * width, 0.0, 1.0));
    vec3 colour = mix(vec3(0.36, 0.235, 0.135), vec3(0.235, 0.140, 0.075), 0.65 * rings);
    colour *= (0.80 + 0.40 * own) * (1.0 + 0.12 * fibre.z + 0.08 * vein.z + 0.05 * warp.z) * (1.0 - 0.55 * split);
    float gap = smooth_edge(cell.x, 0.0016, width + 0.001);
    return Matter(colour * mix(0.22, 1.0, gap),
                  normalize(n - (0.05 * fibre.y + 0.06 * vein.y) * v), 0.02 * gap, 0.55, 0.0);
}

Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    if (axis.w == 0.0) return planks(at, n, u, v, width);
    if (cut_across(n)) return end_grain(at, n, u, v, width);
    return bark(at, n, u, v, width);
}
