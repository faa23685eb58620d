// Stands before what shades snow, ground, bodies and sky. All of them write the light that a sample sends to
// the camera, as film answers to it: linear, 0 to 1.
uniform sampler2D depths;          // of snow smoothed
uniform sampler2D surface;         // normal
uniform sampler2DShadow shadow_all;     // by snow and bodies
uniform sampler3D snow_light;      // scattered sun in rgb, visible sky in alpha

uniform vec3 volume_origin;        // [m]
uniform vec3 volume_size;          // [m]
uniform mat4 shadow_matrix;
uniform float shadow_texel;        // [m]
uniform vec2 disc[12];             // points spread over the unit disc, the outermost first
uniform int shadow_taps;
uniform vec3 to_sun;
uniform float spacing;             // of particles [m]
uniform float haze_distance;       // [m]
uniform float exposure;

out vec4 out_light;

// Light as the radiance of a white matt surface that gets all of it.
const vec3 sun_light = vec3(1.00, 0.94, 0.84);
const vec3 sky_light = vec3(0.26, 0.35, 0.47);

vec3 sky(vec3 direction) {
    float height = 1.0 - exp(-4.0 * max(direction.y, 0.0));
    vec3 colour = mix(vec3(0.50, 0.60, 0.72), vec3(0.11, 0.23, 0.46), height);
    float towards_sun = max(dot(direction, to_sun), 0.0);
    towards_sun *= towards_sun;
    return colour + sun_light * 0.15 * towards_sun * towards_sun;
}

vec3 shadow_position(vec3 position) {
    vec3 at = (shadow_matrix * vec4(position, 1.0)).xyz * 0.5 + 0.5;
    return vec3(at.xy, min(at.z, 1.0));
}

// Share of the sun that is seen, over a disc of `radius` [m]. Where the outermost taps agree, so do all.
float sun_visibility(vec3 position, float radius) {
    vec3 at = shadow_position(position);
    float scale = 0.5 * radius * length(shadow_matrix[0].xyz);
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) sum += texture(shadow_all, vec3(at.xy + scale * disc[i], at.z));
    int taps = sum == 0.0 || sum == 4.0 ? 4 : shadow_taps;
    for (int i = 4; i < taps; ++i) sum += texture(shadow_all, vec3(at.xy + scale * disc[i], at.z));
    return sum / float(taps);
}

// Scattered sun and visible sky; outside the volume, and fading over its rim, there is no snow.
vec4 light_at(vec3 position) {
    vec3 at = (position - volume_origin) / volume_size;
    vec3 rim = clamp(min(at, 1.0 - at) * vec3(textureSize(snow_light, 0)) / 5.0, 0.0, 1.0);
    return mix(vec4(1.0), texture(snow_light, at), rim.x * rim.y * rim.z);
}

// What hides the sky is itself bright snow.
float open_sky(float visible) { return visible / (1.0 - 0.6 * (1.0 - visible)); }

vec3 sky_by_normal(vec3 normal) { return sky_light * (0.65 + 0.35 * normal.y); }

// Light from the snow-covered country below.
vec3 bounce_by_normal(vec3 normal) {
    return 0.5 * (sun_light * to_sun.y + sky_light) * (0.5 - 0.5 * normal.y);
}

// A surface that lets no light in.
vec3 matt(vec3 albedo, vec3 position, vec3 normal) {
    vec3 lifted = position + 1.5 * shadow_texel * normal;  // or it would lie in its own shade
    float direct = max(dot(normal, to_sun), 0.0) * sun_visibility(lifted, 2.0 * shadow_texel);
    float open = open_sky(light_at(position + spacing * normal).a);
    return albedo * (sun_light * direct + open * (sky_by_normal(normal) + bounce_by_normal(normal)));
}

// Film's answer to light: some contrast, and never quite white.
vec3 develop(vec3 light) { return 1.0 - exp(-1.4 * pow(exposure * light, vec3(1.12))); }

// What comes to the eye through the air between.
vec4 seen_through_air(vec3 colour, float depth, vec3 ray) {
    float haze = 1.0 - exp(-depth * length(ray) / haze_distance);
    vec3 horizon = sky(normalize(vec3(ray.x, 0.0, ray.z) + vec3(1e-6, 0.0, 0.0)));
    return vec4(develop(mix(colour, horizon, haze)), 1.0);
}
