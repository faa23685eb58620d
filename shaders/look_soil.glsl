// Clods, crumbs and a few stones; damp in the hollows.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 broad = noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 7.3, width), clod = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.83, width);
    vec3 crumb = noise_at(mat2(0.96, 0.28, -0.28, 0.96) * at, 0.17, width), grain = noise_at(at, 0.047, width);
    float height = 0.45 * clod.z + 0.45 * crumb.z + 0.2 * grain.z;
    float stone = smoothstep(2.3, 2.8, crumb.z + 0.5 * broad.z);
    vec2 slope = 0.06 * broad.xy + 0.22 * clod.xy + (1.0 - 0.6 * stone) * (0.28 * crumb.xy + 0.22 * grain.xy);
    vec3 colour = mix(vec3(0.075, 0.054, 0.038), vec3(0.20, 0.150, 0.105), smoothstep(-1.8, 2.2, height + 0.35 * broad.z));
    colour = mix(colour * (1.0 + 0.14 * grain.z), vec3(0.27, 0.255, 0.235), 0.8 * stone);
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), 0.0, 1.0, 0.0);
}
