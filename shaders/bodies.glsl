// Distance to the bodies, and how much of the sky they hide. They are sorted by kind; the numbers of each, boxes,
// capsules, cylinders and planes, are constants, as max_bodies is: software that draws is slow at uniforms whose place
// is calculated.
uniform vec4 body_a[max_bodies];  // box: centre;  capsule, cylinder: one end;  plane: point
uniform vec4 body_b[max_bodies];  // box: half edges;  capsule, cylinder: other end, radius;  plane: normal
uniform vec4 body_colour[max_bodies];  // albedo in rgb
uniform float body_reach; // [m]

// Colour of the nearest that is no plane, and the distance to it.
vec4 nearest_body(vec3 position) {
    vec4 nearest = vec4(0.0, 0.0, 0.0, 1e9);
    int i = 0;
    for (int end = boxes; i < end; ++i) {
        vec3 q = abs(position - body_a[i].xyz) - body_b[i].xyz;
        float d = length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
        if (d < nearest.w) nearest = vec4(body_colour[i].rgb, d);
    }
    for (int end = i + capsules; i < end; ++i) {
        vec3 d = position - body_a[i].xyz, axis = body_b[i].xyz - body_a[i].xyz;
        float along = clamp(dot(d, axis) / max(dot(axis, axis), 1e-12), 0.0, 1.0);
        float away = length(d - along * axis) - body_b[i].w;
        if (away < nearest.w) nearest = vec4(body_colour[i].rgb, away);
    }
    for (int end = i + cylinders; i < end; ++i) {
        vec3 d = position - body_a[i].xyz, axis = body_b[i].xyz - body_a[i].xyz;
        float length_squared = max(dot(axis, axis), 1e-12), along = dot(d, axis) / length_squared;
        vec2 q = vec2(length(d - along * axis) - body_b[i].w, (abs(along - 0.5) - 0.5) * sqrt(length_squared));
        float away = length(max(q, 0.0)) + min(max(q.x, q.y), 0.0);
        if (away < nearest.w) nearest = vec4(body_colour[i].rgb, away);
    }
    return nearest;
}

float distance_to_bodies(vec3 position) {
    float nearest = nearest_body(position).w;
    int first = boxes + capsules + cylinders;
    for (int i = first; i < first + planes; ++i)
        nearest = min(nearest, dot(position - body_a[i].xyz, body_b[i].xyz));
    return nearest;
}

// Open share of the half space over a surface: how much nearer bodies are than the surface itself.
float open_to_bodies(vec3 position, vec3 normal) {
    float hidden = 0.0, reach = 0.08 * body_reach, weight = 0.24;
    for (int k = 0; k < 4; ++k) {
        hidden += weight * (1.0 - clamp(distance_to_bodies(position + reach * normal) / reach, 0.0, 1.0));
        reach *= 2.3;
        weight *= 0.8;
    }
    return 1.0 - hidden;
}
