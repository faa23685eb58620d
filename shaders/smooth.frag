// One level of an à-trous smoothing of snow's depth [Dammertz et al. 2010], [1 2 1]/4 along both axes:
// neighbours count whose depth is within `range`, and opposite ones, farther off, whose mean is: a plane that is
// seen at a slant is as smooth as one that is faced.
uniform sampler2D depths;
uniform int stride;        // to the neighbours [samples]
uniform float deviation;   // of the whole filter, along one axis [m]
uniform float range;       // [m]

layout(location = 0) out float out_depth;

const ivec2 pairs[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(-1, 1));

float depth_at(ivec2 at) { return texelFetch(depths, clamp(at, ivec2(0), ivec2(samples) - 1), 0).r; }

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    // A level adds a variance of stride²/2; those before it have added (stride² − 1)/6.
    float wanted = deviation / (max(depth, near_depth) * sample_tan), level = float(stride * stride);
    float share = clamp((wanted * wanted - (level - 1.0) / 6.0) / (0.5 * level), 0.0, 1.0);
    float sum = depth, weights = 1.0;
    int count = share > 0.0 ? 4 : 0;
    for (int i = 0; i < count; ++i) {
        vec2 pair = vec2(depth_at(at + stride * pairs[i]), depth_at(at - stride * pairs[i])), gaps = (pair - depth) / range;
        float bend = 0.5 * (gaps.x + gaps.y);
        vec2 weight = max(1.0 - gaps * gaps, max(1.0 - bend * bend, 0.0) * (1.0 - gaps * gaps / 12.0));
        weight = share * (i < 2 ? 0.5 : 0.25) * max(weight, 0.0);
        sum += dot(weight, pair);
        weights += weight.x + weight.y;
    }
    out_depth = sum / weights;
}
