// What lies around, beyond the ground's haze: hills under snow, and a wood before them. Heights are tangents of the
// angle above the horizon.
uniform sampler2D relief;          // slopes and height: 0 to 1 stands for -3 to 3 standard deviations

// Along the horizon, that many tiles around, from -1 to 1 for the most part. What is finer than `blur`, an angle, fades.
float swell(float around, float tiles, float row, float blur) {
    float level = log2(max(0.11 * blur * tiles * float(textureSize(relief, 0).x), 1.0));
    return 3.0 * textureLod(relief, vec2(tiles * around, row), level).z - 1.5;
}

// The sky's colour in a direction, or that of the country before it; `blur` is an angle.
vec3 country_before(vec3 colour, vec3 direction, float blur) {
    float high = direction.y / max(length(direction.xz), 1e-4);
    int at_horizon = high < 0.09 + blur && high > -0.04 ? 1 : 0;  // below it fades, where no ground hides it
    for (int once = 0; once < at_horizon; ++once) {
        vec3 light = light_on_level(), mist = air_at_horizon(direction), seen = colour;
        float around = atan(direction.z, direction.x) / 6.2831853;
        float hill = 0.031 + 0.012 * swell(around, 2.0, 0.15, blur) + 0.003 * swell(around, 9.0, 0.4, blur);
        float slope = swell(around, 11.0, 0.6 + 2.0 * high, blur), woods = swell(around, 200.0, 0.8 + 20.0 * high, blur) + 2.0 * slope;
        vec3 far_off = light * mix(vec3(0.86) + 0.1 * slope, vec3(0.35, 0.39, 0.41), 0.7 * smoothstep(0.5, 2.5, woods));
        far_off = mix(far_off, mist, 0.45 + 0.4 * exp(-50.0 * max(high, 0.0)));
        seen = mix(seen, far_off, fading(hill - blur, hill + blur, high));

        float foot = 0.008 + 0.016 * swell(around, 5.0, 0.25, blur);  // where it sinks below the horizon, there is none
        float wood = foot + 0.004 + 0.0025 * swell(around, 60.0, 0.5, blur) + 0.0035 * abs(swell(around, 170.0, 0.7, blur)) +
                     0.002 * swell(around, 400.0, 0.9, blur);
        float frosted = 0.5 + 0.5 * swell(around, 180.0, 10.0 * high, blur);
        vec3 near = light * vec3(0.045, 0.055, 0.055) * (1.0 + 2.0 * frosted);
        near = mix(near, mist, 0.30 + 0.35 * exp(-120.0 * max(high, 0.0)));
        seen = mix(seen, near, fading(wood - blur, wood + blur, high) * smoothstep(-0.001, 0.006, foot));

        float rise = 0.002 + 0.003 * swell(around, 3.0, 0.33, blur) + 0.0008 * swell(around, 17.0, 0.62, blur);
        seen = mix(seen, mix(0.85 * light, mist, 0.55), fading(rise - 0.5 * blur, rise + 0.5 * blur, high));
        colour = mix(colour, seen, smoothstep(-0.04, 0.0, high));
    }
    return colour;
}
