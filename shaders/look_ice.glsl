// Dark where it is bare, and snow that the wind has left in patches.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 broad = noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 5.3, width), fine = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.5, width);
    vec3 grain = noise_at(mat2(0.96, 0.28, -0.28, 0.96) * at, 0.11, width);
    float crack = fading(0.0, 0.03 + 4.0 * width, abs(noise_at(at + 0.03 * fine.xy, 2.9, width).z)) +
                  0.6 * fading(0.0, 0.02 + 8.0 * width, abs(noise_at(at.yx + 0.02 * fine.xy, 1.1, width).z));
    float blown = 0.9 * broad.z + 0.45 * fine.z + 0.3 * grain.z;
    float frost = smoothstep(-0.5, 0.5, blown), dust = 0.12 * smoothstep(-2.0, 0.0, blown);
    vec3 colour = mix(vec3(0.050, 0.094, 0.115), vec3(0.30, 0.38, 0.42), 0.6 * min(crack, 1.0));
    colour = mix(colour, vec3(0.78, 0.81, 0.84), max(frost, dust));
    vec2 slope = 0.003 * broad.xy + 0.004 * fine.xy + frost * (0.05 * fine.xy + 0.06 * grain.xy);
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), mix(0.05, 0.0, frost), 0.15 + 0.7 * frost, 0.0);
}
