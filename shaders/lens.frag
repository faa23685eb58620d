// Depth of field: light from the disc that the lens spreads it over. What lies before the sharp plane covers a share of
// what is behind; around its edge, what it hides is taken to go on as beside it.
uniform sampler2D light;
uniform sampler2D depths;          // 0: the sky
uniform sampler2D reach;           // of discs before the sharp plane, for blocks of samples [samples]
uniform float max_radius;          // [samples]
uniform float turn;                // of the taps, 0 to 1: each moment's lie between those of the others
uniform float edge;                // samples along a pixel's edge

layout(location = 0) out vec4 out_light;
layout(location = 1) out float out_depth;  // of what comes here, for what is drawn after it

const float far_away = 1e9;         // [m]
const float golden_angle = 2.399963;

float depth_at(ivec2 place) {
    float depth = texelFetch(depths, place, 0).r;
    return depth > 0.0 ? depth : far_away;
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), last = ivec2(samples) - 1;
    float own_depth = depth_at(at), own = min(blur_at(own_depth), max_radius);
    // Light, and how much of it comes here: the disc's area is what it is spread over.
    float own_share = 1.0 / max(3.1416 * own * own, 1.0), nearness = own_share / own_depth;
    vec4 base = own_share * vec4(texelFetch(light, at, 0).rgb, 1.0), cover = vec4(0.0);
    // How far taps must go: what is behind this, or no nearer than the sharp plane, counts as spread no wider than this.
    float widest = max(own, texelFetch(reach, at / lens_block, 0).r);
    const int most = 48;
    int taps = widest > 0.6 ? most : 0;
    ivec2 place = edge < 2.0 ? ivec2(0) : at & 1;  // each of a pixel's four samples has taps between those of the others
    float between = fract(turn + 0.25 * float(2 * (place.x ^ place.y) + place.y));
    for (int i = 0; i < taps; ++i) {
        float share = sqrt((float(i) + between) / float(most)), radius = widest * share * sqrt(share);
        float angle = golden_angle * (float(i) + 13.0 * between);  // a spiral, turned with the pattern
        ivec2 there = clamp(at + ivec2(round(radius * vec2(cos(angle), sin(angle)))), ivec2(0), last);
        float depth = depth_at(there), blur = min(blur_at(depth), max_radius);
        bool before = depth < min(own_depth, focus);
        if (depth > own_depth) blur = own_depth < focus ? own : min(blur, own);
        // They are denser at the middle, for small discs: each stands for its part of the area, d(r²)/di.
        float part = 1.5 * widest * widest * share / float(most);
        float comes_here = clamp(blur - radius + 0.5, 0.0, 1.0) * part / max(blur * blur, 0.32);
        vec4 comes = comes_here * vec4(texelFetch(light, there, 0).rgb, 1.0);
        nearness += comes_here / depth;
        if (before) cover += comes;
        else base += comes;
    }
    // The taps' sum scatters about the share that is covered: what is all covered would shine through where it falls short.
    vec3 sum = mix(base.rgb / base.a, cover.rgb / max(cover.a, 1e-6), min(1.1 * cover.a, 1.0));
    out_light = vec4(undeveloped ? film_curve(sum) : sum, 1.0);
    out_depth = (base.a + cover.a) / nearness;
}
