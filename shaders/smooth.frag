// Bilateral smoothing of snow's depth along lines in one direction: neighbours count whose depth is within
// `range`.
uniform sampler2D depths;
uniform int along_x, along_y;  // step to the next sample of a line
uniform float radius;      // of the filter [m]
uniform float range;       // [m]
uniform int max_taps;      // to either side

layout(location = 0) out float out_depth;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 axis = ivec2(along_x, along_y);
    float depth = texelFetch(depths, at, 0).r;

    float reach = radius / (max(depth, near_depth) * sample_tan * length(vec2(axis)));  // [steps]
    float stride = max(1.0, ceil(reach / float(max_taps)));
    int taps = min(max_taps, int(reach / stride));
    float sum = depth, weights = 1.0;
    for (int i = 1; i <= taps; ++i) {
        float t = float(i) * stride / reach;
        float near_by = (1.0 - t * t) * (1.0 - t * t);
        ivec2 offset = axis * int(float(i) * stride);
        ivec2 last = ivec2(samples) - 1;
        float before = texelFetch(depths, clamp(at - offset, ivec2(0), last), 0).r;
        float after = texelFetch(depths, clamp(at + offset, ivec2(0), last), 0).r;
        vec2 gap = (vec2(before, after) - depth) / range;
        vec2 weight = near_by * max(1.0 - gap * gap, 0.0);
        sum += dot(weight, vec2(before, after));
        weights += weight.x + weight.y;
    }
    out_depth = sum / weights;
}
