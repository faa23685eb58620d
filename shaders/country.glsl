// What lies around, beyond the ground's haze: hills under snow, and woods before them. Heights are tangents
// of the angle above the horizon.
uniform sampler2D relief;          // slopes and height: 0 to 1 stands for -3 to 3 standard deviations

// Along the horizon, that many tiles around, from -1 to 1 for the most part. What is finer than `blur`, an angle, fades.
float swell(float around, float tiles, float row, float blur) {
    float level = log2(max(0.11 * blur * tiles * float(textureSize(relief, 0).x), 1.0));
    return 3.0 * textureLod(relief, vec2(tiles * around, row), level).z - 1.5;
}

// A wood before what is behind it, so far off that no tree stands out: `tall` where it is tallest; `clear` is the share of
// its light that comes through the air; `row` of the noise makes each another one.
vec3 wood_before(vec3 behind, float around, float high, float row, float tall, float clear, vec3 mist, float blur) {
    float stands = 0.5 + 0.4 * swell(around, 3.0, row, blur) + 0.25 * swell(around, 17.0, row, blur);  // else there is a clearing
    float crown = 0.16 * swell(around, 90.0, row, blur) + 0.12 * swell(around, 300.0, row, blur);
    float top = tall * (clamp(stands, 0.0, 1.0) + crown * smoothstep(0.0, 0.3, stands));
    float bough = swell(around, 140.0, row + 20.0 * high, blur), twig = swell(around, 420.0, row + 60.0 * high, blur);
    float frosted = smoothstep(0.0, 2.0, bough + 0.8 * twig + 0.5);
    vec3 colour = light_on_level() * mix(vec3(0.030, 0.038, 0.038), vec3(0.24, 0.27, 0.31), 0.45 * frosted);
    return mix(behind, mix(mist, colour, clear), fading(top - 2.0 * blur, top + blur, high) * smoothstep(0.0, 0.15, stands));
}

// The sky's colour in a direction, or that of the country before it; `blur` is an angle.
vec3 country_before(vec3 colour, vec3 direction, float blur) {
    float high = direction.y / max(length(direction.xz), 1e-4);
    int at_horizon = high < 0.14 + blur && high > -0.04 ? 1 : 0;  // below it fades, where no ground hides it
    for (int once = 0; once < at_horizon; ++once) {
        vec3 light = light_on_level(), mist = air_at_horizon(direction), seen = colour;
        float around = atan(direction.z, direction.x) / 6.2831853, towards = towards_sun(direction);
        float hill = 0.045 + 0.018 * swell(around, 2.0, 0.15, blur) + 0.004 * swell(around, 9.0, 0.4, blur);
        float slope = swell(around, 11.0, 0.6 + 2.0 * high, blur), woods = swell(around, 200.0, 0.8 + 20.0 * high, blur) + 2.0 * slope;
        vec3 far_off = light * mix(vec3(0.86) + 0.1 * slope, vec3(0.35, 0.39, 0.41), 0.7 * smoothstep(0.5, 2.5, woods));
        far_off = mix(far_off, mist, 0.45 + 0.4 * exp(-50.0 * max(high, 0.0)));
        seen = mix(seen, far_off, fading(hill - blur, hill + blur, high));

        float clear = 1.0 - 0.45 * towards * towards * towards;  // the nearer to the sun, the more the air shines
        seen = wood_before(seen, around, high - 0.6 * hill, 0.71, 0.012, 0.32 * clear, mist, blur);
        seen = wood_before(seen, around, high, 0.37, 0.024, 0.62 * clear, mist, blur);

        float rise = 0.004 + 0.007 * swell(around, 4.0, 0.33, blur) + 0.0015 * swell(around, 23.0, 0.62, blur) + 0.0008 * swell(around, 160.0, 0.2, blur);
        seen = mix(seen, mix(0.85 * light, mist, most_haze), fading(rise - blur, rise + blur, high));
        colour = mix(colour, seen, smoothstep(-0.04, 0.0, high));
    }
    return colour;
}

// The sky in a surface that is not quite smooth; what lies below the horizon is the ground.
vec3 mirrored_country(vec3 direction, float rough) {
    vec3 up = sky(normalize(direction + vec3(0.0, 0.5 * rough, 0.0)));
    up = country_before(up, direction, 0.02 + 0.2 * rough);
    vec3 even = sky_by_normal(direction) + bounce_by_normal(direction, 1.0);
    return mix(mix(0.8 * ground * even, up, smoothstep(-0.15 * rough - 0.02, 0.15 * rough + 0.02, direction.y)), even, 0.6 * rough);
}
