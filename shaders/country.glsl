// What lies around, beyond the ground's haze: hills under snow, and the edges of woods before them. Heights are tangents
// of the angle above the horizon.
uniform sampler2D relief;          // slopes and height: 0 to 1 stands for -3 to 3 standard deviations

// Along the horizon, that many tiles around, from -1 to 1 for the most part. What is finer than `blur`, an angle, fades.
float swell(float around, float tiles, float row, float blur) {
    float level = log2(max(0.11 * blur * tiles * float(textureSize(relief, 0).x), 1.0));
    return 3.0 * textureLod(relief, vec2(tiles * around, row), level).z - 1.5;
}

// Two from 0 to 1 [PCG, Jarzynski and Olano 2020]; in whole numbers, or each driver would plant trees of its own.
vec2 numbers_of(uint n) {
    n = n * 747796405u + 2891336453u;
    n = ((n >> ((n >> 28u) + 4u)) ^ n) * 277803737u;
    n = (n >> 22u) ^ n;
    return vec2(float(n & 65535u), float(n >> 16u)) / 65535.0;
}

// Of that many conifers around in a row, and as many smaller ones: the top, from 0 to 1, as it is at the height `y`, since
// boughs hang in tiers; a number of the tree that has it; and how far from its middle this is, -1 to 1, `up` the tree.
vec3 tree_tops(float around, float count, float y, float up, float uneven) {
    float at = around * count, cell = floor(at);
    vec3 top = vec3(0.0, 0.5, 0.0);
    for (float i = -1.0; i <= 1.5; i += 0.5) {  // by turns: large at i, small at i + 1/2
        float young = fract(i) > 0.0 ? 0.55 : 1.0;
        vec2 h = numbers_of(uint(mod(2.0 * (cell + i), 2.0 * count)));
        float from = at - cell - floor(i) - h.x, aside = abs(from) * (0.88 + 0.28 * fract(13.0 * y + 7.0 * h.x) + uneven);
        float tallest = young * (0.5 + 0.5 * h.y), wide = young * (0.42 + 0.35 * h.y), height = tallest * (1.0 - aside / wide);
        if (height > top.x) top = vec3(height, fract(5.0 * h.x), from / (wide * max(1.0 - up / tallest, 0.1)));
    }
    return top;
}

// A wood's edge before what is behind it, that stands so high; `clear` is the share of its light that comes through the
// mist, which is thickest at its foot. `sun_at`: the sun's parts along the horizon and towards the eye.
vec3 wood_before(vec3 behind, float around, float high, float count, float tall, float clear, vec3 mist, vec2 sun_at, float blur) {
    const float turn = 6.2831853;
    float stands = smoothstep(-0.75, -0.25, swell(around, 3.0, 0.01 * count, 0.15));  // else there is a clearing
    float bough = swell(around, 0.7 * count, 0.7 * count * high / turn, blur), twig = swell(around, 3.0 * count, 3.0 * count * high / turn, blur);
    float hedge = 0.42 + 0.25 * swell(around, 0.05 * count, 0.3, blur), up = max(high / tall - hedge, 0.0) / 0.65;  // trees stand behind others
    vec3 tree = tree_tops(around, count, high / tall, up, 0.10 * bough + 0.20 * twig);
    tree = mix(tree, vec3(0.5, 0.5, 0.0), smoothstep(0.4, 1.2, blur * count / turn));  // trees finer than that are but a wood
    float top = tall * stands * (hedge + 0.65 * tree.x);
    // Boughs face the sun on one side of a tree, some of them snow.
    float aside = clamp(tree.z + 0.3 * bough, -1.0, 1.0);
    float facing = max(aside * sun_at.x + sqrt(1.0 - aside * aside) * sun_at.y + 0.3 * to_sun.y + 0.2 * twig, 0.0);
    float frosted = smoothstep(0.0, 1.2, bough + 0.8 * twig + 0.3 * (high / tall) + 0.15);
    float under_sky = mix(0.3, 1.0, smoothstep(0.0, 0.6, 1.0 - max(top - high, 0.0) / tall));  // lower boughs lie in shade
    vec3 reached = under_sky * (1.2 * facing * sun_light + 0.7 * sky_light);
    vec3 colour = reached * mix((0.5 + tree.y) * vec3(0.024, 0.032, 0.028), vec3(0.34, 0.37, 0.40), (0.4 + 0.4 * tree.y) * frosted);
    colour = mix(mist, colour, clear * (1.0 - 0.15 * exp(-2.5 * max(high, 0.0) / tall)));
    float soft = min(5.0 * blur, 0.02 + blur);  // sides of trees are five times as steep
    return mix(behind, colour, fading(top - soft, top + soft, high) * smoothstep(0.0, 0.3, stands));
}

// The sky's colour in a direction, or that of the country before it; `blur` is an angle.
vec3 country_before(vec3 colour, vec3 direction, float blur) {
    float high = direction.y / max(length(direction.xz), 1e-4);
    int at_horizon = high < 0.17 + blur && high > -0.04 ? 1 : 0;  // below it fades, where no ground hides it
    for (int once = 0; once < at_horizon; ++once) {
        vec3 light = light_on_level(), mist = air_at_horizon(direction), seen = colour;
        float around = atan(direction.z, direction.x) / 6.2831853, towards = towards_sun(direction);
        float hill = 0.045 + 0.018 * swell(around, 2.0, 0.15, blur) + 0.004 * swell(around, 9.0, 0.4, blur);
        float slope = swell(around, 11.0, 0.6 + 2.0 * high, blur), woods = swell(around, 200.0, 0.8 + 20.0 * high, blur) + 2.0 * slope;
        vec3 far_off = light * mix(vec3(0.86) + 0.1 * slope, vec3(0.35, 0.39, 0.41), 0.7 * smoothstep(0.5, 2.5, woods));
        far_off = mix(far_off, mist, 0.45 + 0.4 * exp(-50.0 * max(high, 0.0)));
        seen = mix(seen, far_off, fading(hill - blur, hill + blur, high));

        vec2 way = normalize(direction.xz + vec2(1e-6, 0.0)), sun_at = vec2(dot(to_sun.xz, vec2(-way.y, way.x)), -dot(to_sun.xz, way));
        float clear = 1.0 - 0.45 * towards * towards * towards;  // the nearer to the sun, the more the air shines
        seen = wood_before(seen, around, high - 0.7 * hill, 1060.0, 0.040, 0.30 * clear, mist, sun_at, blur);
        seen = wood_before(seen, around, high - 0.010, 640.0, 0.060, 0.50 * clear, mist, sun_at, blur);
        seen = wood_before(seen, around, high, 400.0, 0.090, 0.80 * clear, mist, sun_at, blur);
        seen = wood_before(seen, around, high, 910.0, 0.034, 0.85 * clear, mist, sun_at, blur);  // young trees at its edge

        float rise = 0.004 + 0.007 * swell(around, 4.0, 0.33, blur) + 0.0015 * swell(around, 23.0, 0.62, blur) + 0.0008 * swell(around, 160.0, 0.2, blur);
        seen = mix(seen, mix(0.85 * light, mist, most_haze), fading(rise - 0.5 * blur, rise + 0.5 * blur, high));
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
