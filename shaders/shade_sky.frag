uniform float aperture;            // [m]; a lens blurs what is far by itself

out vec4 out_light;

void main() {
    vec3 direction = normalize(ray_through(gl_FragCoord.xy));
    float towards = max(dot(direction, to_sun), 0.0);
    float disc_of_sun = 6.0 * smoothstep(0.99993, 0.99998, towards), glow = 0.30 * pow(towards, 250.0) + 0.7 * pow(towards, 1500.0) + 2.0 * pow(towards, 8000.0);
    vec3 seen = sky(direction) + sun_light * (disc_of_sun + glow);
    out_light = vec4(on_film(country_before(seen, direction, max(2.0 * sample_tan, aperture > 0.0 ? 0.0 : 0.002))), 1.0);
}
