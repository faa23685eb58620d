uniform sampler2D depths;
uniform sampler2D surface;         // normal
uniform vec3 moved;                // of the body since the start: its pattern goes along [m]
uniform vec4 snow_ground;          // n and -n.p of a ground of snow; of none, all is far over it

out vec4 out_light;

// The pattern runs along the body: on each side of what is flat it is that of the nearest of the three planes, and goes
// around what is round, from below to below. The ends of a cylinder are flat.
Matter matter_at(vec3 position, vec3 n, float width) {
    vec3 size = abs(n * lie), out_of_axis = (position - axis.xyz) * lie;
    bool end = axis.w > 0.0 ? cut_across(n) : size.x > max(size.y, size.z);
    bool around = axis.w > 0.0 && !end;
    float off = length(out_of_axis.yz), narrow = around ? max(off / axis.w, 0.02) : 1.0;  // a round end is narrower
    vec3 u = end ? lie[2] : lie[0];
    vec3 v = around ? (lie[2] * out_of_axis.y - lie[1] * out_of_axis.z) / max(off, 1e-6) : !end && size.y >= size.z ? lie[2] : lie[1];
    vec2 at = vec2(dot(position, u), around ? axis.w * atan(out_of_axis.z, out_of_axis.y) : dot(position, v));
    return matter_of(at, n, u, v, width / narrow);
}

// Over a ground of snow, wind has left some on what is level, but for bare metal, from which it slides.
Matter with_snow(Matter bare, vec3 position, vec3 face, float width) {
    float level = dot(snow_ground.xyz, face);
    int lies = bare.soft == 0.0 && bare.mirror < 0.3 && level > 0.65 ? 1 : 0;
    for (int once = 0; once < lies; ++once) {
        vec2 at = position.xz - moved.xz;
        vec3 broad = noise_at(at, 0.9, width), fine = noise_at(at.yx, 0.22, width), grain = noise_at(at, 19.0 * spacing, width);
        float cover = smooth_edge(broad.z + 0.5 * fine.z + 0.5 * grain.z + 10.0 * (level - 1.0), 0.4, 0.8);
        vec2 slope = 0.03 * fine.xy + 0.10 * grain.xy + 1.2 * cover * (1.0 - cover) * (broad.xy + 0.5 * fine.yx);  // thick at its rim
        bare.albedo = mix(bare.albedo, snow_albedo, cover);
        bare.normal = normalize(mix(bare.normal, face - vec3(slope.x, 0.0, slope.y), cover));
        bare.mirror *= 1.0 - cover;
        bare.soft = cover * snow_wrap;
    }
    return bare;
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, texel, 0).r;
    vec3 ray = ray_through(gl_FragCoord.xy);
    vec3 position = eye + depth * ray, towards = normalize(ray);
    vec3 face = normal_of(texelFetch(surface, texel, 0));
    float width = depth * sample_tan / sqrt(max(abs(dot(towards, face)), 0.01));
    Matter m = with_snow(matter_at(position - moved, face, width), position, face, width);

    // Or it would lie in its own shade; and snow is no darker beneath a single grain that lies on it. Between the grains
    // of a foot it is lit as what stands before them: else dark specks would show there.
    float snowy = m.soft / snow_wrap;
    vec4 outward = texture(snow_outward, (position + spacing * face - volume_origin) / volume_size);
    outward.xyz -= dot(outward.xyz, face) * face;
    vec3 before = 2.5 * snowy * smoothstep(0.02, 0.2, outward.a) * spacing * outward.xyz / max(length(outward.xyz), 1e-4);
    vec3 lifted = position + max(1.5 * shadow_texel, 1.2 * spacing * snowy) * face + before;
    // The sun that grazes a face reaches neither side of what rises from it.
    float level = max(dot(face, to_sun), 0.0);
    float uneven = smoothstep(0.0, 0.2, level), facing = mix(level, dot(m.normal, to_sun), uneven);
    facing = max((facing + m.soft * uneven) / (1.0 + m.soft), 0.0);
    float inside = scattering * uneven * m.soft / snow_wrap;  // share of light that comes out of snow again
    float through = spray_transmittance(lifted);
    float seen = sun_visibility(lifted, max(facing, inside), 1.5 * shadow_texel) * through, direct = facing * seen;
    vec3 sun = seen * mix(vec3(facing), share_let_in(level) * deep, inside);
    vec4 light = light_at(position + spacing * face + before);
    int powdered = through < 1.0 ? 1 : 0;
    for (int once = 0; once < powdered; ++once)
        sun += thrown_on_by_powder(m.normal, sqrt(through)) * texture(shadow_bodies, shadow_position(lifted)) * sqrt(light.rgb);
    float open = open_to_bodies(position, face);
    open *= open_sky(light.a);
    open *= 1.0 + 0.6 * dot(m.normal - face, brightest_sky());
    vec3 colour = m.albedo * (sun_light * sun + open * (sky_by_normal(m.normal) + bounce_by_normal(m.normal, open)));

    int sparkles = m.soft > 0.0 && direct > 0.0 && width < 0.35 * spacing ? 1 : 0;
    for (int once = 0; once < sparkles; ++once)
        colour += 5.0 * m.soft / snow_wrap * glint(position - moved, m.normal, ray, width) * direct * sun_light;

    if (m.mirror > 0.0) {
        vec3 mirror_way = reflect(towards, m.normal), half_way = normalize(to_sun - towards);
        float fresnel = m.mirror + (1.0 - m.mirror) * pow(1.0 - clamp(dot(-towards, m.normal), 0.0, 1.0), 5.0) * (1.0 - m.rough);
        float sharp = 2.0 / (m.rough * m.rough * m.rough * m.rough + 1e-3);
        float gloss = (sharp + 2.0) / 8.0 * pow(max(dot(half_way, m.normal), 0.0), sharp);
        vec4 body = mirrored_body(position, mirror_way), snow = mirrored_snow(position, mirror_way, body.w);
        vec3 behind = body.w < 1e9 ? body.rgb : open * mirrored_country(mirror_way, m.rough);
        colour = colour * (1.0 - fresnel) + fresnel * (snow.rgb + snow.a * behind + min(gloss, 12.0) * direct * sun_light);
    }
    out_light = vec4(seen_through_air(colour, depth, ray), 1.0);
}
