void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    vec3 ray = ray_through(gl_FragCoord.xy);
    vec3 normal = normalize(texelFetch(surface, at, 0).xyz * 2.0 - 1.0);
    vec3 colour = matt(vec3(0.30, 0.265, 0.235), eye + depth * ray, normal);
    out_light = seen_through_air(colour, depth, ray);
}
