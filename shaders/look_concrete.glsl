// Cast in a form: bubbles at its face, paler where lime has come out, and rain has run down what is upright.
Matter matter_of(vec2 at, vec3 n, vec3 u, vec3 v, float width) {
    float upright = 1.0 - abs(dot(n, lie[1]));
    vec3 cloud = noise_at(at, 2.3, width), blotch = noise_at(mat2(0.8, 0.6, -0.6, 0.8) * at, 0.61, width);
    vec3 run = noise_at(vec2(1.0, 0.07) * at + 0.02 * blotch.xy, 0.55, width);
    vec3 sand = noise_at(mat2(0.96, 0.28, -0.28, 0.96) * at, 0.057, 0.6 * width);
    float hole = smoothstep(2.2, 3.0, noise_at(mat2(0.6, -0.8, 0.8, 0.6) * at, 0.13, width).z + 0.5 * blotch.z);
    float wet = upright * smoothstep(-0.2, 2.2, run.z + 0.8 * cloud.z);
    vec3 colour = vec3(0.265, 0.258, 0.250) * (1.0 + 0.10 * cloud.z + 0.03 * blotch.z + 0.075 * sand.z);
    colour = mix(colour, vec3(0.155, 0.150, 0.142) * (1.0 + 0.08 * sand.z), 0.6 * wet);
    colour *= 1.0 - 0.45 * hole;
    vec2 slope = 0.015 * blotch.xy + 0.06 * sand.xy;
    return Matter(colour, normalize(n - slope.x * u - slope.y * v), 0.0, 1.0, 0.0);
}
