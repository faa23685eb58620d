// Depth of field: light from the disc that the lens spreads it over. What lies in front of the sharp plane
// spreads over what is behind, not the other way about.
uniform sampler2D light;
uniform sampler2D depths;          // 0: the sky
uniform float aperture;            // diameter [m]
uniform float focus;               // [m]
uniform float max_radius;          // [samples]

out vec4 out_light;

// Radius of the disc of a point at that depth, in samples:  A |d − f| / (2 d f tan).
float blur_at(float depth) {
    float spread = depth > 0.0 ? abs(depth - focus) / depth : 1.0;
    return min(0.5 * aperture * spread / (focus * sample_tan), max_radius);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), last = ivec2(samples) - 1;
    float own_depth = texelFetch(depths, at, 0).r, own = blur_at(own_depth);
    if (own_depth == 0.0) own_depth = 1e9;
    vec3 sum = texelFetch(light, at, 0).rgb;
    float weights = 1.0;
    const int taps = 48;
    for (int i = 0; i < taps; ++i) {
        float radius = max_radius * sqrt((float(i) + 0.5) / float(taps)), turn = 2.399963 * float(i);
        ivec2 there = clamp(at + ivec2(round(radius * vec2(cos(turn), sin(turn)))), ivec2(0), last);
        float depth = texelFetch(depths, there, 0).r, blur = blur_at(depth);
        if (depth == 0.0) depth = 1e9;
        if (depth > own_depth) blur = min(blur, own);
        float weight = clamp(blur - radius + 1.0, 0.0, 1.0) * max_radius * max_radius / (max(blur * blur, 1.0) * float(taps));
        sum += weight * texelFetch(light, there, 0).rgb;
        weights += weight;
    }
    out_light = vec4(sum / weights, 1.0);
}
