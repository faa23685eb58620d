// Drifts, hollows and the grain, which is as fine as a particle's.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    vec3 drift = even_noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 1700.0 * spacing, max(width, 60.0 * spacing));
    vec3 fine = noise_at(at, 310.0 * spacing, max(width, 6.0 * spacing));
    vec2 bent = mat2(0.6, -0.8, 0.8, 0.6) * at + 5.0 * spacing * drift.zx;  // or its tile would be seen to repeat
    vec3 grain = noise_at(bent, 19.0 * spacing, 1.5 * width);
    float near = 1.0 / (1.0 + width / (12.0 * spacing));  // from afar one sees crests alone, which are lit alike
    grain *= 0.7 + 0.3 * clamp(0.6 + fine.z, 0.0, 1.6);  // patches of wind-packed snow are smoother
    const mat2 wind = mat2(0.96, 0.28, -0.56, 1.92);  // ridges, twice as long as wide, of a hand's width and more
    vec2 blown = noise_at(wind * at + 0.1 * drift.xz, 2.3, max(width, 0.1)).xy * wind;
    float ridges = 0.045 / (1.0 + 8.0 * width);  // width [m]
    vec2 slope = near * (0.11 * drift + 0.035 * fine + 0.10 * grain).xy + ridges * blown;
    return Matter(snow_albedo * (1.0 + near * (0.01 * fine.z + 0.03 * grain.z)),
                  normalize(n - slope.x * u - slope.y * v), 0.0, 0.0, snow_wrap);
}
