// One level of an à-trous smoothing of snow's depth [Dammertz et al. 2010], [1 2 1]/4 along both axes:
// neighbours count whose depth is within `range`.
uniform sampler2D depths;
uniform int stride;        // to the neighbours [samples]
uniform float deviation;   // of the whole filter, along one axis [m]
uniform float range;       // [m]

layout(location = 0) out float out_depth;

const ivec2 neighbours[8] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(1, 1),
                                    ivec2(-1, 1), ivec2(1, -1), ivec2(-1, -1));

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), last = ivec2(samples) - 1;
    float depth = texelFetch(depths, at, 0).r;
    // A level adds a variance of stride²/2; those before it have added (stride² − 1)/6.
    float wanted = deviation / (max(depth, near_depth) * sample_tan), level = float(stride * stride);
    float share = clamp((wanted * wanted - (level - 1.0) / 6.0) / (0.5 * level), 0.0, 1.0);
    float sum = depth, weights = 1.0;
    int count = share > 0.0 ? 8 : 0;
    for (int i = 0; i < count; ++i) {
        float neighbour = texelFetch(depths, clamp(at + stride * neighbours[i], ivec2(0), last), 0).r;
        float gap = (neighbour - depth) / range;
        float weight = share * (i < 4 ? 0.5 : 0.25) * max(1.0 - gap * gap, 0.0);
        sum += weight * neighbour;
        weights += weight;
    }
    out_depth = sum / weights;
}
