uniform sampler2D depths;          // smoothed
uniform sampler2D wide_depths;     // smoothed over a lump
uniform sampler2D raw_depths;
uniform sampler2D surface;         // grain's normal
uniform sampler3D snow_outward;    // −∇ρ over two cells; ρ in alpha

uniform float edge;                // samples along a pixel's edge
uniform vec4 snow_ground;          // n and -n.p of a ground of snow; of none, all is far over it
uniform bool coloured;             // by a colour map
uniform sampler2D values;          // 0 to 1
uniform sampler2D palette;

out vec4 out_light;

// From smoothed depth: the smaller of the two differences along each axis, which does not cross an edge. Shorter than 1
// where it is steep: one sample beside an edge on either side tells little.
vec3 normal_of_depth(sampler2D map, ivec2 at, float depth) {
    ivec2 last = ivec2(samples) - 1;
    float left = depth - texelFetch(map, max(at - ivec2(1, 0), ivec2(0)), 0).r;
    float right = texelFetch(map, min(at + ivec2(1, 0), last), 0).r - depth;
    float below = depth - texelFetch(map, max(at - ivec2(0, 1), ivec2(0)), 0).r;
    float above = texelFetch(map, min(at + ivec2(0, 1), last), 0).r - depth;
    vec2 slope = vec2(abs(left) < abs(right) ? left : right, abs(below) < abs(above) ? below : above);
    // position = depth · ray:  ∂/∂x = slope ray + depth ∂ray/∂x, and the normal is ∂/∂y × ∂/∂x.
    vec3 ray = vec3((vec2(at) + 0.5 - 0.5 * samples) * sample_tan, 1.0);
    vec3 along_x = slope.x * ray + vec3(depth * sample_tan, 0.0, 0.0);
    vec3 along_y = slope.y * ray + vec3(0.0, depth * sample_tan, 0.0);
    float steep = min(length(slope) / (4.0 * depth * sample_tan), 5.0);  // more would make it vanish
    steep *= steep;
    return basis * normalize(cross(along_y, along_x)) / (1.0 + steep * steep);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    vec3 ray = ray_through(gl_FragCoord.xy);
    vec3 position = eye + depth * ray;
    vec3 grain = normal_of(texelFetch(surface, at, 0));
    vec4 outward = texture(snow_outward, (position - volume_origin) / volume_size);
    // Where a sample is wide, grain is finer than it; a particle wider than a few pixels is no grain, but has some.
    float across = spacing / (depth * sample_tan), wide_enough = smoothstep(1.7, 2.7, across / edge);
    float grain_share = mix(0.21, 0.15, wide_enough) * clamp(1.5 - 0.5 / across, 0.3, 1.0);
    vec3 smooth_normal = normal_of_depth(depths, at, depth);
    // A grain that faces the eye where all around is grazed would be a dark speck.
    float dense = length(outward.xyz), agrees = dot(smooth_normal, outward.xyz) / max(dense * length(smooth_normal), 1e-4);
    smooth_normal *= mix(1.0, max(smoothstep(-0.1, 0.8, agrees), 0.001), smoothstep(0.1, 0.3, dense));
    float sure = length(smooth_normal);
    grain = mix(grain, normalize(smooth_normal + sure * (grain + basis[2])), wide_enough);
    vec3 normal = normalize(mix(smooth_normal, sure * grain, grain_share) + outward.xyz);

    // What thins out over a ground of snow becomes it: single grains that lie there would make a seam.
    float thins = fading(0.7, 3.0, (dot(snow_ground.xyz, position) + snow_ground.w) / spacing);
    int low = thins > 0.0 ? 1 : 0;
    for (int once = 0; once < low; ++once) {  // not where more snow stands above, as over a steep foot
        vec3 above = (position + 6.0 * spacing * snow_ground.xyz - volume_origin) / volume_size;
        thins *= fading(0.1, 0.4, texture(snow_outward, above).a);
    }
    normal = normalize(mix(normal, snow_ground.xyz, thins) + vec3(1e-5, 0.0, 0.0));

    // Pits of the grain and hollows between lumps see less of the light.
    float raw = texelFetch(raw_depths, at, 0).r, wide = texelFetch(wide_depths, at, 0).r;
    float across_surface = abs(dot(normal, normalize(ray)));  // or a plane that is grazed would have hollows
    float pit = clamp((raw - depth) / spacing, -0.6, 0.8);
    float hollow = clamp((depth - wide) * across_surface / (2.2 * spacing), -0.7, 0.9);
    float pitted = mix(0.12, 0.02, wide_enough);  // a lump of its own shows no pits
    float loose = fading(0.06, 0.32, outward.a);  // light finds its way between grains, and through what is thin
    float open = clamp(1.0 - (1.0 - 0.4 * loose) * (pitted * pit + 0.65 * hollow) * (1.0 - thins), 0.3, 1.25);

    vec3 lifted = position + 1.2 * spacing * normal;  // or it would lie in its own shade
    vec4 light = light_at(position + spacing * normal);
    float facing = clamp((dot(normal, to_sun) + snow_wrap) / (1.0 + snow_wrap), 0.0, 1.0);
    float thin = sqrt(spray_transmittance(lifted));  // half of the cloud lies behind
    float direct = facing * sun_visibility(lifted, facing, 0.8 * spacing) * thin * mix(1.0, open, 0.46);
    float past_bodies = texture(shadow_bodies, shadow_position(lifted));
    // What is loose takes it from all sides.
    float let_in = share_let_in(dot(outward.xyz, to_sun) / max(dense, 1e-4));
    vec3 inside = past_bodies * light.rgb * deep * mix(1.0, let_in, smoothstep(0.02, 0.1, dense) * (1.0 - loose));
    float scattered = scattering + loose * (0.02 + 0.08 * light.g);
    // Grains send most of the light nearly straight on: against the sun, what is thin shines.
    float against = max(dot(normalize(ray), to_sun), 0.0), through = light.g * light.g * light.g;
    float reached = 0.0, last = against > 0.1 ? 8.0 : 0.0;
    for (float ahead = 2.0; ahead <= last; ahead += 3.0)
        reached += texture(shadow_all, shadow_position(position + ahead * spacing * to_sun)) / 3.0;
    float grazed = 1.0 - min(across_surface, 1.0);  // and most at its outline
    inside += (2.0 + 12.0 * grazed * grazed * grazed) * against * against * against * through * reached * past_bodies * (1.0 - direct) * deep;
    vec3 sun = sun_light * (mix(vec3(direct), inside, scattered) + thrown_on_by_powder(normal, thin) * past_bodies * sqrt(light.rgb));
    float seen = open_sky(clamp(light.a * open, 0.22, 1.0)) * lifted_by_snow(open_to_bodies(position, normal));
    seen *= max(1.0 + (0.4 + 0.9 * fading(0.0, 0.4, direct)) * grain_share * dot(grain - normal, brightest_sky()), 0.0);
    vec3 around = seen * (sky_by_normal(normal) + (0.7 + 0.3 * seen) * bounce_by_normal(normal, min(seen, 1.0)));
    if (coloured) {
        // Shaded only as far as it takes to see the shape: the colours must be those of the scale.
        vec3 own = texture(palette, vec2(texelFetch(values, at, 0).r, 0.5)).rgb;
        float shade = dot(sun + around, vec3(0.2126, 0.7152, 0.0722));
        out_light = vec4(pow(own, vec3(2.2)) * mix(0.55, 1.0, smoothstep(0.0, 1.2, shade)), 1.0);
        return;
    }
    float sparkle = glint(position, smooth_normal / sure, ray, depth * sample_tan);
    out_light = vec4(seen_through_air(snow_albedo * (sun + around) + 4.0 * sparkle * direct * sun_light, depth, ray), 1.0);
}
