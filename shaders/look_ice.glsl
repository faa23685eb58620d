Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 broad = noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 5.3, width), fine = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.5, width);
    float crack = smoothstep(0.05 + 4.0 * width, 0.0, abs(noise_at(at + 0.03 * fine.xy, 2.9, width).z)) +
                  0.6 * smoothstep(0.03 + 8.0 * width, 0.0, abs(noise_at(at.yx + 0.02 * fine.xy, 1.1, width).z));
    float frost = smoothstep(-1.2, 2.2, broad.z + 0.6 * fine.z);
    vec3 colour = mix(vec3(0.155, 0.235, 0.275), vec3(0.60, 0.68, 0.73), 0.75 * frost);
    colour = mix(colour, vec3(0.80, 0.86, 0.90), 0.6 * min(crack, 1.0));
    vec2 slope = 0.004 * broad.xy + 0.006 * fine.xy;
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), mix(0.05, 0.015, frost), 0.25 + 0.5 * frost);
}
