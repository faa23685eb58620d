// How wide are the discs of what lies before the sharp plane, that may reach a block of samples: those of the block
// itself, then those around. A constant, `around`, tells which.
uniform sampler2D depths;          // 0: the sky
uniform sampler2D widest;          // of each block [samples]
uniform float max_radius;          // [samples]

out float out_radius;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    out_radius = 0.0;
    if (around == 0) {
        ivec2 first = at * lens_block, end = min(first + lens_block, ivec2(samples));
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x) {
                float depth = texelFetch(depths, ivec2(x, y), 0).r;
                if (depth > 0.0 && depth < focus) out_radius = max(out_radius, min(blur_at(depth), max_radius));
            }
    } else {
        int reach = int(ceil(max_radius / float(lens_block)));
        ivec2 last = textureSize(widest, 0) - 1;
        for (int j = -reach; j <= reach; ++j)
            for (int i = -reach; i <= reach; ++i) {
                float radius = texelFetch(widest, clamp(at + ivec2(i, j), ivec2(0), last), 0).r;
                if (radius >= float(lens_block * (max(abs(i), abs(j)) - 1))) out_radius = max(out_radius, radius);
            }
    }
}
