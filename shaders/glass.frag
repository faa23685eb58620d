// A plate of glass before what is already drawn: mirrors the country around, and takes a little of what comes through.
in vec3 world_position;
in vec3 world_normal;

uniform float max_depth_inside;    // of the plate [m]

layout(location = 0, index = 0) out vec4 out_light;
layout(location = 0, index = 1) out vec4 out_passed;

void main() {
    vec3 towards = normalize(world_position - eye), normal = normalize(world_normal);
    float facing = clamp(dot(-towards, normal), 0.0, 1.0);
    float fresnel = 0.04 + 0.96 * pow(1.0 - facing, 5.0);
    vec3 mirror_way = reflect(towards, normal);
    vec3 seen = mirrored_country(mirror_way, 0.0);
    vec3 half_way = normalize(to_sun - towards);
    vec3 gloss = sun_light * 6.0 * pow(max(dot(half_way, normal), 0.0), 600.0);
    float path = max_depth_inside / max(facing, 0.25);
    vec3 passed = exp(-path * vec3(4.0, 1.2, 2.0)) * (1.0 - fresnel);
    vec3 own = 0.10 * (1.0 - passed.g) * passed * light_on_level();  // its few bubbles and dust
    out_light = vec4(on_film(fresnel * (seen + gloss) + own), 0.0);
    out_passed = vec4(passed, 1.0);
}
