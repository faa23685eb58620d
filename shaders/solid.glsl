// What grounds and bodies are made of, without pictures: from one tile of noise at several sizes. Each look has a
// shader of its own, since software that draws takes every branch.
uniform sampler3D snow_outward;    // −∇ρ over two cells; ρ in alpha
uniform mat3 lie;                  // columns: along the body, up, and across
uniform vec4 axis;                 // of what is round about its length: a point on it, radius; 0 of what is flat [m]

struct Matter {
    vec3 albedo;
    vec3 normal;
    float mirror;                  // share of light that is mirrored straight on
    float rough;                   // blur of what is mirrored
    float soft;                    // how far sunlight reaches around the edge of shade, as a cosine
};

// Is it an end of a cylinder, or the middle of a round one, over whose rim the samples of each go by turns?
bool cut_across(vec3 n) {
    return axis.w > 0.0 && abs(dot(n, lie[0])) > 0.65 + 0.2 * spread_evenly(floor(gl_FragCoord.xy));
}

// Slopes along u and v, and height, of noise whose tile is so wide [m]. What is smaller than a sample fades.
vec3 noise_at(vec2 at, float tile, float width) {
    float level = log2(max(width / tile * float(textureSize(relief, 0).x), 1e-6));
    // One of the two nearest sizes, by turns among 2×2 samples, is half the work of their mean.
    ivec2 turn = ivec2(gl_FragCoord.xy) & 1;
    return 6.0 * textureLod(relief, at / tile, level + 0.25 * float(2 * (turn.x ^ turn.y) + turn.y) - 0.375).xyz - 3.0;
}

// The same, as the mean, for what shifts or bends something finer: turns would show there.
vec3 even_noise_at(vec2 at, float tile, float width) {
    float level = max(log2(max(width / tile * float(textureSize(relief, 0).x), 1e-6)), 0.0), lower = floor(level);
    return 6.0 * mix(textureLod(relief, at / tile, lower), textureLod(relief, at / tile, lower + 1.0), level - lower).xyz - 3.0;
}

float smooth_edge(float distance_in, float edge, float width) {
    return clamp((distance_in - edge) / max(width, 1e-6) + 0.5, 0.0, 1.0);
}

// Distance to the nearest border of the cell that `at` is in, and the cell.
vec3 cell_at(vec2 at, vec2 size) {
    vec2 cell = floor(at / size), inside = at - cell * size;
    vec2 border = min(inside, size - inside);
    return vec3(min(border.x, border.y), cell);
}

// From 0 to 1 [PCG, Jarzynski and Olano 2020]; in whole numbers, or each driver would lay tiles of its own.
float hash_at(vec2 cell) {
    uint n = (uint(int(cell.x)) + 65537u * uint(int(cell.y))) * 747796405u + 2891336453u;
    n = ((n >> ((n >> 28u) + 4u)) ^ n) * 277803737u;
    n = (n >> 22u) ^ n;
    return float(n & 65535u) / 65535.0;
}

// A body that stands in the way from a mirror, of one colour: its light, and how far it is. Planes are not looked for.
vec4 mirrored_body(vec3 from, vec3 way) {
    float along = 4.0 * shadow_texel;
    vec4 nearest = vec4(1e9);
    int steps = boxes + capsules + cylinders > 0 ? 16 : 0;
    for (int i = 0; i < steps && nearest.w > 0.002 * along && along < 20.0 * body_reach; ++i) {
        nearest = nearest_body(from + along * way);
        along += nearest.w;
    }
    int found = nearest.w < 0.02 * along ? 1 : 0;
    vec4 result = vec4(0.0, 0.0, 0.0, 1e9);
    for (int once = 0; once < found; ++once) {
        vec3 at = from + along * way;
        vec2 aside = vec2(0.01 * along, 0.0);
        vec3 normal = normalize(vec3(nearest_body(at + aside.xyy).w, nearest_body(at + aside.yxy).w, nearest_body(at + aside.yyx).w) -
                                nearest_body(at).w + vec3(0.0, 1e-6, 0.0));
        float direct = max(dot(normal, to_sun), 0.0) * texture(shadow_all, shadow_position(at + 4.0 * shadow_texel * normal));
        result = vec4(nearest.rgb * (direct * sun_light + sky_by_normal(normal) + bounce_by_normal(normal, 1.0)), along);
    }
    return result;
}

// Snow in the same way, as far as `reach`: its light, and in alpha what it leaves of what is behind.
vec4 mirrored_snow(vec3 from, vec3 way, float reach) {
    const int most = 12;
    vec3 a = (volume_origin - from) / way, b = (volume_origin + volume_size - from) / way, low = min(a, b), high = max(a, b);
    float begin = max(max(low.x, max(low.y, low.z)), 2.0 * spacing), end = min(min(high.x, reach), min(high.y, high.z));
    float stride = (end - begin) / float(most);
    vec3 pace = stride * way / volume_size;
    vec3 at = (from + begin * way - volume_origin) / volume_size + spread_evenly(floor(gl_FragCoord.xy)) * pace;
    vec4 result = vec4(0.0, 0.0, 0.0, 1.0);
    int steps = end > begin ? most : 0;
    for (int i = 0; i < steps && result.a > 0.01; ++i, at += pace) {
        vec4 outward = texture(snow_outward, at);
        float hidden = clamp(1.5 * outward.a * min(stride / spacing, 4.0), 0.0, 1.0);
        int any = hidden > 0.0 ? 1 : 0;
        for (int once = 0; once < any; ++once) {
            vec4 light = texture(snow_light, at - 0.6 * pace);  // just before
            vec3 normal = outward.xyz / max(length(outward.xyz), 1e-4);
            vec3 colour = sun_light * light.rgb * (0.3 + 0.7 * max(dot(normal, to_sun), 0.0)) + open_sky(light.a) * sky_by_normal(normal);
            result += result.a * hidden * vec4(colour, -1.0);
        }
    }
    return result;
}
