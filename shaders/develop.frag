// What the film shows, linear, to sRGB of 8 bits.
uniform sampler2D film;

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
    out_colour = vec4(srgb(texelFetch(film, pixel, 0).rgb) + dither(pixel) / 255.0, 1.0);
}
