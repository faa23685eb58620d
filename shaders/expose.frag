// From samples to pixels, a tent over each that reaches its neighbours' middles, in linear light: what one moment adds.
// A constant, `edge`: samples along a pixel's edge.
uniform sampler2D light;
uniform int margin;                // [samples]
uniform float share;               // of the picture: one of its moments

out vec4 out_light;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(light, 0) - margin - 1;
    vec3 sum = vec3(0.0);
    for (int j = -(edge / 2); j < edge + edge / 2; ++j)
        for (int i = -(edge / 2); i < edge + edge / 2; ++i) {
            vec2 tent = 1.0 - abs((vec2(i, j) + 0.5) / float(edge) - 0.5);
            sum += tent.x * tent.y * texelFetch(light, clamp(margin + pixel * edge + ivec2(i, j), ivec2(margin), last), 0).rgb;
        }
    out_light = vec4(share * sum / float(edge * edge), 1.0);
}
