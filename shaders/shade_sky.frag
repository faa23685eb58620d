out vec4 out_light;

void main() {
    vec3 direction = normalize(ray_through(gl_FragCoord.xy));
    float disc_of_sun = smoothstep(0.99985, 0.99993, dot(direction, to_sun)) * 6.0;
    float glow = 0.6 * pow(max(dot(direction, to_sun), 0.0), 700.0);
    vec3 seen = sky(direction) + sun_light * (disc_of_sun + glow);
    out_light = vec4(develop(country_before(seen, direction, max(2.0 * sample_tan, 0.002))), 1.0);
}
