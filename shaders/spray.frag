uniform sampler2D raw_depths;      // behind a lens: of what it has spread to each sample
uniform float aperture;            // [m]
uniform float spacing;             // of particles [m]

flat in vec4 spray_colour;
flat in vec2 half_way;
flat in float spray_radius;
flat in float spray_size;
flat in float spray_depth;
flat in float spray_hash;
in float spray_end;

out vec4 out_light;

// A puff that a surface cuts through ends softly; and so does a grain where a lens has spread the surface: there the
// depth test, which knows none but sharp ones, is off.
float before_surface() {
    float behind = texelFetch(raw_depths, ivec2(gl_FragCoord.xy), 0).r, gap = (behind - spray_depth) / spacing;
    if (behind <= 0.0) return 1.0;
    return puffs == 1 ? clamp(0.5 * gap, 0.0, 1.0) : aperture > 0.0 ? clamp(2.0 * gap + 0.5, 0.0, 1.0) : 1.0;
}

float share_hidden() {
    if (lines == 1) return spray_colour.a * (0.15 + 1.1 * spray_end);
    vec2 p = (gl_PointCoord - 0.5) * vec2(spray_size, -spray_size);
    float along = dot(p, half_way) / max(dot(half_way, half_way), 1e-6);
    vec2 q = p - clamp(along, -1.0, 1.0) * half_way;
    float d = dot(q, q) / (spray_radius * spray_radius);
    if (d >= 1.0) discard;
    float opacity = spray_colour.a * (puffs == 1 ? (1.0 - d) * (1.0 - d) : 1.0 - d * d);
    if (puffs == 1) {  // a constant
        // Each is uneven in its own way.
        vec4 bend = 2.0 * fract(spray_hash * vec4(37.7, 311.3, 733.1, 171.9)) - 1.0;
        vec2 at = p / (spray_radius + length(half_way));
        opacity *= clamp(0.9 + 1.7 * (dot(bend.xy, at) + dot(bend.zw, vec2(at.x * at.x - at.y * at.y, 2.0 * at.x * at.y))), 0.0, 2.0);
    }
    return opacity;
}

void main() {
    out_light = vec4(spray_colour.rgb, share_hidden() * before_surface());
}
