uniform sampler2DShadow shadow_bodies;  // by bodies alone: snow lets light through
uniform sampler3D snow_outward;    // −∇ρ over two cells; ρ in alpha

const float albedo = 0.97;
const float wrap = 0.20;           // how far sunlight reaches around the edge of shade, as a cosine
const float scattering = 0.22;     // share of the sun that was inside before it comes out

// From smoothed depth: the smaller of the two differences along each axis, which does not cross an edge.
vec3 normal_of_depth(ivec2 at, float depth) {
    ivec2 last = ivec2(samples) - 1;
    float left = depth - texelFetch(depths, max(at - ivec2(1, 0), ivec2(0)), 0).r;
    float right = texelFetch(depths, min(at + ivec2(1, 0), last), 0).r - depth;
    float below = depth - texelFetch(depths, max(at - ivec2(0, 1), ivec2(0)), 0).r;
    float above = texelFetch(depths, min(at + ivec2(0, 1), last), 0).r - depth;
    vec2 slope = vec2(abs(left) < abs(right) ? left : right, abs(below) < abs(above) ? below : above);
    // position = depth · ray:  ∂/∂x = slope ray + depth ∂ray/∂x, and the normal is ∂/∂y × ∂/∂x.
    vec3 ray = vec3((vec2(at) + 0.5 - 0.5 * samples) * sample_tan, 1.0);
    vec3 along_x = slope.x * ray + vec3(depth * sample_tan, 0.0, 0.0);
    vec3 along_y = slope.y * ray + vec3(0.0, depth * sample_tan, 0.0);
    return basis * normalize(cross(along_y, along_x));
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    vec3 ray = ray_through(gl_FragCoord.xy);
    vec3 position = eye + depth * ray;
    vec3 grain = normalize(texelFetch(surface, at, 0).xyz * 2.0 - 1.0);
    vec3 outward = texture(snow_outward, (position - volume_origin) / volume_size).xyz;
    vec3 normal = normalize(mix(normal_of_depth(at, depth), grain, 0.25) + 1.2 * outward);

    vec3 lifted = position + 1.2 * spacing * normal;  // or it would lie in its own shade
    vec4 light = light_at(position + spacing * normal);
    float facing = clamp((dot(normal, to_sun) + wrap) / (1.0 + wrap), 0.0, 1.0);
    float direct = facing * sun_visibility(lifted, spacing);
    float past_bodies = texture(shadow_bodies, shadow_position(lifted));
    vec3 sun = sun_light * mix(vec3(direct), past_bodies * light.rgb, scattering);
    vec3 around = open_sky(light.a) * (sky_by_normal(normal) + bounce_by_normal(normal));
    out_light = seen_through_air(albedo * (sun + around), depth, ray);
}
