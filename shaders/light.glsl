// What shades snow, spray, solids and sky shares. All of it writes the light that a sample sends to the camera, linear:
// as film answers to it, 0 to 1, or as it is, if a lens has to spread it first.
uniform sampler2DShadow shadow_all;     // by snow and bodies
uniform sampler2DShadow shadow_bodies;  // by bodies alone: snow lets light through
uniform sampler2DShadow shadow_far;     // the same of a wider country
uniform sampler2D shadow_depths;        // the same texture as numbers
uniform sampler2D spray_shadow;         // optical depth of the spray between the sun and what is solid
uniform sampler2D shadow_bounds;        // least and largest depth near, any spray (shadow_bounds.frag)
uniform sampler3D snow_light;           // scattered sun in rgb, visible sky in alpha

uniform vec3 volume_origin;        // [m]
uniform vec3 volume_size;          // [m]
uniform mat4 shadow_matrix;
uniform float shadow_texel;        // [m]
uniform mat4 far_matrix;
uniform float far_texel;           // [m]; 0: all bodies are in the other maps
uniform float shadow_reach;        // farthest that shadow_bounds looks [m]
uniform float shadow_span;         // between the map's nearest and farthest depth [m]
uniform int shadow_search;         // samples that look for what throws half-shade
uniform int shadow_taps;
uniform vec3 to_sun;
uniform vec3 sun_light;            // radiance of a white matt surface that faces the sun
uniform vec3 sky_light;            // of one that sees all of the sky
uniform vec3 sky_horizon, sky_zenith;
uniform vec3 ground;               // light that comes back from it, as a share of what snow returns
uniform float spacing;             // of particles [m]
uniform float haze_distance;       // [m]
uniform float exposure;
uniform bool undeveloped;          // what is drawn now meets the film curve later

// About the sun, most along the horizon; `towards` is the cosine of the angle to it.
vec3 glow_of_air(float towards, float height) {
    float wide = towards * towards * towards * towards;
    return sun_light * (0.10 * wide + 0.25 * exp(-5.0 * abs(height)) * wide * wide * wide);
}

// Without the sun itself.
vec3 sky(vec3 direction) {
    vec3 colour = mix(sky_zenith, sky_horizon, exp(-5.5 * max(direction.y, 0.0)));
    return colour + glow_of_air(max(dot(direction, to_sun), 0.0), direction.y);
}

vec3 shadow_position(vec3 position) {
    vec3 at = (shadow_matrix * vec4(position, 1.0)).xyz * 0.5 + 0.5;
    return vec3(at.xy, min(at.z, 1.0));
}

// 0 to 1, spread evenly among neighbouring cells [interleaved gradient noise, Jimenez 2014].
float spread_evenly(vec2 cell) { return fract(52.9829189 * fract(dot(cell, vec2(0.06711056, 0.00583715)))); }

// Turns the taps of a sample. Bound to the place in the shadow map, not in the picture: it rests with the scene. The
// places are halves of a texel, or wide enough for two samples across: finer ones would flicker when the camera moves.
vec2 turn_at(vec2 at, float width) {
    vec2 cell = floor(at * 2.0 * vec2(textureSize(shadow_depths, 0)) / exp2(ceil(log2(max(4.0 * width / shadow_texel, 1.0)))));
    float angle = 6.2832 * spread_evenly(cell);
    return vec2(cos(angle), sin(angle));
}

vec3 bounds_near(vec3 at) {
    ivec2 size = textureSize(shadow_bounds, 0);
    return texelFetch(shadow_bounds, clamp(ivec2(at.xy * vec2(size)), ivec2(0), size - 1), 0).xyz;
}

const mat2 golden = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688);  // a turn by the golden angle: spreads evenly

// Software that draws takes every branch, but leaves a loop as soon as it can: loops of one turn stand for branches.
float half_shade(vec3 at, float least_radius, float width) {
    const float sun_radius = 0.022;    // tangent of half its angle, with the haze
    float scale = 0.5 * length(shadow_matrix[0].xyz);
    float search = min(max(least_radius, sun_radius * at.z * shadow_span), shadow_reach);
    vec2 turn = turn_at(at.xy, width);
    float gaps = 0.0, blockers = 0.0;
    for (int i = 0; i < shadow_search; ++i) {
        float gap = at.z - texture(shadow_depths, at.xy + scale * search * sqrt((float(i) + 0.5) / float(shadow_search)) * turn).r;
        if (gap > 0.0) gaps += gap, blockers += 1.0;
        turn = golden * turn;
    }
    float radius = clamp(sun_radius * shadow_span * gaps / max(blockers, 1.0), least_radius, search);
    float sum = 0.0;
    int taps = blockers == 0.0 ? 0 : shadow_taps;
    for (int i = 0; i < taps; ++i) {
        sum += texture(shadow_all, vec3(at.xy + scale * radius * sqrt((float(i) + 0.5) / float(taps)) * turn, at.z));
        turn = golden * turn;
    }
    return blockers == 0.0 ? 1.0 : sum / float(shadow_taps);
}

// Share of the sun that is seen: its disc, and the haze about it, make shade softer the farther it falls. It does not
// matter where the sun does not reach the surface anyway, `facing` none of it.
float sun_visibility(vec3 position, float facing, float least_radius) {
    vec3 at = shadow_position(position), bounds = bounds_near(at);
    bool over = all(lessThan(abs(at.xy - 0.5), vec2(0.5)));
    float seen = over && at.z > bounds.y ? 0.0 : 1.0;
    int unsure = over && at.z > bounds.x && at.z <= bounds.y && facing > 0.0 ? 1 : 0;
    for (int once = 0; once < unsure; ++once) seen = half_shade(at, least_radius, dot(position - eye, basis[2]) * sample_tan);
    // Before and behind the map's depths it does not tell bodies from what they shade.
    int beyond = far_texel > 0.0 && seen > 0.0 && !(over && abs(at.z - 0.5) < 0.5) ? 1 : 0;
    for (int once = 0; once < beyond; ++once) {
        vec3 far = (far_matrix * vec4(position + 2.5 * far_texel * to_sun, 1.0)).xyz * 0.5 + 0.5;
        seen = min(seen, texture(shadow_far, vec3(far.xy, min(far.z, 1.0))));
    }
    return seen;
}

// Of the sun, through powder: what goes straight on, and what is scattered to about the same place.
float spray_transmittance(vec3 position) {
    vec3 at = shadow_position(position);
    int any = bounds_near(at).z > 0.0 ? 1 : 0;
    float through = 1.0;
    for (int once = 0; once < any; ++once) {
        float depth = texture(spray_shadow, at.xy).r;
        through = mix(exp(-depth), 1.0 / (1.0 + 0.11 * depth), 0.1);
    }
    return through;
}

// Of what powder takes from the sun's rays, to let `through` that share, it throws on somewhat less than half, most of it about
// their way.
float thrown_on_by_powder(vec3 normal, float through) {
    return (0.25 + 0.16 * dot(normal, to_sun)) * (1.0 - through);
}

// Scattered sun and visible sky; outside the volume, and fading over its rim, snow only throws shade.
vec4 light_at(vec3 position) {
    vec3 at = (position - volume_origin) / volume_size;
    vec3 rim = clamp(min(at, 1.0 - at) * vec3(textureSize(snow_light, 0)) / 5.0, 0.0, 1.0);
    float share = rim.x * rim.y * rim.z;
    vec4 light = vec4(1.0);
    int outside = share < 1.0 ? 1 : 0, inside = share > 0.0 ? 1 : 0;
    for (int once = 0; once < outside; ++once) light.rgb *= texture(shadow_all, shadow_position(position + 1.5 * spacing * to_sun));
    for (int once = 0; once < inside; ++once) light = mix(light, texture(snow_light, at), share);
    return light;
}

// What hides the sky is itself bright snow.
float open_sky(float visible) { return visible / (1.0 - 0.68 * (1.0 - visible)); }

// Most of the sky's light comes from the sun's side: what leans there is lighter, in shade as well.
vec3 brightest_sky() { return normalize(to_sun + vec3(0.0, 1.0, 0.0)); }

vec3 sky_by_normal(vec3 normal) { return sky_light * (0.65 + 0.35 * normal.y + 0.28 * dot(normal.xz, to_sun.xz)); }

// Light from the country below, a share of which lies in the sun.
vec3 bounce_by_normal(vec3 normal, float sunlit) {
    const vec3 shaded = vec3(0.91, 1.0, 1.08);  // some of it lies in blue shade
    return 0.55 * shaded * ground * (sunlit * max(to_sun.y, 0.0) * sun_light + sky_light) * (0.5 - 0.5 * normal.y);
}

// Film's answer to light: a toe, contrast, and a shoulder that is never quite white.
vec3 film_curve(vec3 light) {
    vec3 x = exposure * max(light, vec3(0.0));
    return 1.0 - exp(-1.55 * pow(x, vec3(1.45)));
}

// As the film shows it, unless a lens has to spread it first.
vec3 on_film(vec3 light) { return undeveloped ? light : film_curve(light); }

// Of a surface that bright snow stands before.
float lifted_by_snow(float open) { return open / (1.0 - 0.65 * (1.0 - open)); }

const vec3 snow_albedo = vec3(0.965, 0.972, 0.98);
const vec3 deep = vec3(0.86, 1.0, 1.16);  // colour of light that has been inside: ice takes the red
const float scattering = 0.18;     // share of the sun that was inside before it comes out
const float snow_wrap = 0.16;      // how far sunlight reaches around the edge of shade on snow, as a cosine

// The more obliquely the sun falls, the less of it gets in.
float share_let_in(float facing) { return clamp((facing + 0.5) / 1.5, 0.1, 1.0); }

vec3 light_on_level() { return max(to_sun.y, 0.0) * sun_light + sky_light; }

// At the horizon below a direction.
float towards_sun(vec3 way) { return max(dot(normalize(way.xz + vec2(1e-6, 0.0)), to_sun.xz), 0.0); }

// Of far air over snow.
vec3 air_at_horizon(vec3 way) {
    return mix(sky_horizon, 0.8 * light_on_level(), 0.35) + glow_of_air(towards_sun(way), 0.0);
}

// What comes to the eye through the air between, of which there is only so much before the country around.
const float most_haze = 0.55;
vec3 seen_through_air(vec3 colour, float depth, vec3 ray) {
    float haze = most_haze * (1.0 - exp(-depth * length(ray) / (most_haze * haze_distance)));
    return on_film(mix(colour, air_at_horizon(ray), haze));
}
