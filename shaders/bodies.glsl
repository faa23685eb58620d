// Distance to the bodies, and how much of the sky they hide.
uniform int bodies;
uniform vec4 body_a[16];  // box: centre, 0;  capsule: one end, 1;  cylinder: one end, 2;  plane: point, 3
uniform vec4 body_b[16];  // box: half edges;  capsule, cylinder: other end, radius;  plane: normal
uniform float body_reach; // [m]

float distance_to_body(int i, vec3 position) {
    vec3 d = position - body_a[i].xyz, b = body_b[i].xyz;
    if (body_a[i].w < 0.5) {
        vec3 q = abs(d) - b;
        return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
    }
    if (body_a[i].w > 2.5) return dot(d, b);
    vec3 axis = b - body_a[i].xyz;
    float length_squared = max(dot(axis, axis), 1e-12), along = dot(d, axis) / length_squared;
    if (body_a[i].w < 1.5) return length(d - clamp(along, 0.0, 1.0) * axis) - body_b[i].w;
    vec2 q = vec2(length(d - along * axis) - body_b[i].w, (abs(along - 0.5) - 0.5) * sqrt(length_squared));
    return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0);
}

// Open share of the half space over a surface: how much nearer bodies are than the surface itself.
float open_to_bodies(vec3 position, vec3 normal) {
    float hidden = 0.0, reach = 0.08 * body_reach, weight = 0.24;
    for (int k = 0; k < 4; ++k) {
        vec3 at = position + reach * normal;
        float nearest = reach;
        for (int i = 0; i < bodies; ++i) nearest = min(nearest, distance_to_body(i, at));
        hidden += weight * (1.0 - max(nearest, 0.0) / reach);
        reach *= 2.3;
        weight *= 0.8;
    }
    return 1.0 - hidden;
}
