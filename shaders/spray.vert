// Powder in the air: a thin puff, or else grains in it, points or lines where they go far while
// the shutter is open: the constants `puffs` and `lines` tell. Every particle stands twice in the buffer: for both ends of a line.
layout(location = 0) in vec3 center;
layout(location = 1) in vec3 velocity;   // [m/s]
layout(location = 2) in float amount;    // 0 to 1
layout(location = 3) in float hash;
layout(location = 4) in float value;
layout(location = 5) in float crumb;     // radius [m]
layout(location = 6) in float puff_radius;  // [m]
layout(location = 7) in float powder;    // 0 to 1
uniform float max_point_size;
uniform float shutter;                   // [s]
uniform float puff_share;                // of the particles have puffs
uniform bool coloured;                   // by a colour map
uniform sampler2D palette;
uniform sampler3D snow_outward;          // −∇ρ over two cells; ρ in alpha
uniform float edge;                      // samples along a pixel's edge

flat out vec4 spray_colour;              // as film shows it, and how much it hides of what is behind
flat out vec2 half_way;                  // of the streak [samples]
flat out float spray_radius;             // [samples]
flat out float spray_size;               // [samples]
flat out float spray_depth;              // [m]
flat out float spray_hash;
out float spray_end;                     // of a streak: it fades towards where the grain came from

void main() {
    const bool puff = puffs == 1;
    int grain = puff ? 0 : gl_InstanceID + lines;
    bool whole = !puff && grain == 0;    // the crumb itself
    vec3 h = fract(hash * vec3(71.3, 433.1, 191.9) + float(grain) * vec3(0.6180, 0.4142, 0.7321));
    vec3 at = center + (puff || whole ? vec3(0.0) : mix(1.5, 2.4, clamp(2.0 * amount - 1.0, 0.0, 1.0)) * spacing * (h - 0.5));
    float r = whole ? 1.2 * crumb : puff ? puff_radius : spacing * (0.07 + 0.16 * h.x * h.y);
    float opacity = whole ? 1.0 : puff ? (coloured ? 0.12 : 0.10) * inversesqrt(puff_share) * powder : 0.85 * amount;

    spray_depth = dot(at - eye, basis[2]);
    float sample_width = max(spray_depth, near_depth) * sample_tan;
    vec3 ray = (at - eye) / max(spray_depth, near_depth);
    float sharp = r / sample_width, least = 0.55 * edge, width = max(sharp, least);
    float blur = blur_at(max(spray_depth, near_depth));
    float widest = 0.5 * max_point_size - 1.0;
    float radius = lines == 1 ? width : clamp(length(vec2(sharp, blur)), least, widest);
    opacity *= min(sharp * sharp / (radius * radius), 1.0);  // what is smaller than a pixel hides a share of it
    opacity *= fading(0.15, 0.35, 2.0 * width / max_point_size);  // at the lens
    vec3 way = transpose(basis) * velocity * (0.5 * shutter);
    vec2 straight = (way.xy - way.z * (transpose(basis) * ray).xy) / sample_width;
    float length_of_way = length(straight);
    bool streak = !puff && !whole && length_of_way > 2.0 * width;
    float longest = puff ? 1.2 * radius : max(0.5 * max_point_size - radius - 1.0, 0.0);
    straight = (0.2 + 0.8 * h.z * h.z) * mat2(1.0, 0.5 * h.y - 0.25, 0.25 - 0.5 * h.y, 1.0) * straight;  // the air whirls
    half_way = straight * min(1.0, longest / max(length_of_way, 1e-6));
    // What flies to or from the eye hides no more than what flies across.
    float blurred = max(length_of_way, 0.15 * shutter * length(velocity) / sample_width);
    opacity *= radius / (radius + (whole ? 1.27 * length(half_way) : puff ? 0.7 * length(half_way) : 0.5 * blurred));
    spray_radius = radius;
    spray_size = 2.0 * (radius + length(half_way)) + 1.0;
    spray_hash = hash;

    // A cloud has a lit and a shaded side: the denser it is, the more it answers to light as a surface does.
    vec4 light = light_at(at), outward = texture(snow_outward, (at - volume_origin) / volume_size);
    // Thin dust has no dark side: it scatters what has come through it to all sides.
    float slope = length(outward.xyz), dense = smoothstep(0.02, 0.10, outward.a) * smoothstep(0.05, 0.6, slope / (outward.a + 0.01));
    dense *= 1.0 - 0.75 * light.g * light.g;
    vec3 normal = outward.xyz / max(slope, 1e-6);
    float seen = texture(shadow_all, shadow_position(at + 1.5 * spacing * to_sun));
    float forward = max(dot(normalize(ray), to_sun), 0.0);  // ice throws most of the light onwards
    float facing = mix(0.62, 0.92 * max(dot(normal, to_sun) + 0.25, 0.0) / 1.25, dense) + 1.2 * pow(forward, 6.0);
    // In the shade of snow there is scattered light, of which ice has taken the red; in that of bodies none.
    float past_bodies = texture(shadow_bodies, shadow_position(at));
    vec3 sun = sun_light * light.rgb * past_bodies * mix(vec3(0.25, 0.29, 0.33), vec3(facing), seen);
    vec3 colour = sun + (0.75 * open_sky(light.a)) * (sky_light * (1.0 + 0.3 * dense * normal.y) + bounce_by_normal(dense * normal, seen));

    if (lines == 1) opacity = min(3.0 * opacity * min(radius, 1.5), 0.8);
    spray_colour = vec4(seen_through_air(colour, spray_depth, ray), opacity);
    if (coloured) spray_colour.rgb = pow(textureLod(palette, vec2(value, 0.5), 0.0).rgb, vec3(2.2));
    bool shown = streak == (lines == 1) && (!puff || hash < puff_share) && opacity > 0.004 && r > 0.0 && spray_depth > near_depth;
    gl_Position = shown ? projection * vec4(at, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    if (lines == 1) {  // which cannot be wide: out of focus each lies elsewhere on the lens's disc
        vec2 on_disc = fract(hash * vec2(523.7, 277.3) + float(grain) * vec2(0.7549, 0.5698));
        vec2 aside = blur * sqrt(on_disc.x) * vec2(cos(6.2832 * on_disc.y), sin(6.2832 * on_disc.y));
        gl_Position.xy += 2.0 * aside / samples * gl_Position.w;
    }
    spray_end = (gl_VertexID & 1) == 0 ? 0.0 : 1.0;
    if (lines == 1) gl_Position.xy += ((gl_VertexID & 1) == 0 ? -2.0 : 2.0) * straight / samples * gl_Position.w;
    gl_PointSize = min(spray_size, max_point_size);
}
