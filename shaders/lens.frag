// Depth of field: light from the disc that the lens spreads it over. What lies in front of the sharp plane
// spreads over what is behind, not the other way about.
uniform sampler2D light;
uniform sampler2D depths;          // 0: the sky
uniform float max_radius;          // [samples]
uniform float turn;                // of the taps, 0 to 1: each moment's lie between those of the others
uniform float edge;                // samples along a pixel's edge

out vec4 out_light;

const float far_away = 1e9;         // [m]

float depth_at(ivec2 place) {
    float depth = texelFetch(depths, place, 0).r;
    return depth > 0.0 ? depth : far_away;
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), last = ivec2(samples) - 1;
    float own_depth = depth_at(at), own = min(blur_at(own_depth), max_radius);
    float weights = 1.0 / max(3.1416 * own * own, 1.0);  // of light that is spread over a disc, what comes here
    vec3 sum = weights * texelFetch(light, at, 0).rgb;
    const int taps = 48;
    ivec2 place = edge < 2.0 ? ivec2(0) : at & 1;  // so do those of a pixel's samples
    float between = fract(turn + 0.25 * float(2 * (place.x ^ place.y) + place.y));
    for (int i = 0; i < taps; ++i) {
        float share = sqrt((float(i) + between) / float(taps)), radius = max_radius * share * sqrt(share), angle = 2.399963 * (float(i) + 13.0 * between);
        ivec2 there = clamp(at + ivec2(round(radius * vec2(cos(angle), sin(angle)))), ivec2(0), last);
        float depth = depth_at(there), blur = min(blur_at(depth), max_radius);
        if (depth > own_depth) blur = min(blur, own);
        // They are denser at the middle, for small discs: each stands for its part, d(πr²)/di, of a disc of light.
        float weight = clamp(blur - radius + 0.5, 0.0, 1.0) * 1.5 * max_radius * max_radius * share / (max(blur * blur, 0.32) * float(taps));
        sum += weight * texelFetch(light, there, 0).rgb;
        weights += weight;
    }
    out_light = vec4(undeveloped ? develop(sum / weights) : sum / weights, 1.0);
}
