// From samples to pixels, a tent over each that reaches its neighbours' middles, in linear light, and from there to sRGB.
// A constant, `edge`: samples along a pixel's edge.
uniform sampler2D light;
uniform int margin;                // [samples]

out vec4 out_colour;

vec3 srgb(vec3 linear) {
    return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
}

// Half a step of 8 bits up or down, in a fixed 8×8 pattern: skies do not fall into bands.
float dither(ivec2 pixel) {
    int x = pixel.x ^ pixel.y, y = pixel.y;
    int rank = (x & 1) << 5 | (y & 1) << 4 | (x & 2) << 2 | (y & 2) << 1 | (x & 4) >> 1 | (y & 4) >> 2;
    return (float(rank) + 0.5) / 64.0 - 0.5;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(light, 0) - margin - 1;
    vec3 sum = vec3(0.0);
    for (int j = -(edge / 2); j < edge + edge / 2; ++j)
        for (int i = -(edge / 2); i < edge + edge / 2; ++i) {
            vec2 share = 1.0 - abs((vec2(i, j) + 0.5) / float(edge) - 0.5);
            sum += share.x * share.y * texelFetch(light, clamp(margin + pixel * edge + ivec2(i, j), ivec2(margin), last), 0).rgb;
        }
    out_colour = vec4(srgb(sum / float(edge * edge)) + dither(pixel) / 255.0, 1.0);
}
