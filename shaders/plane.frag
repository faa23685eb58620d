// A plane, as far as one sees.
uniform vec3 plane_point;
uniform vec3 plane_normal;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_surface;

void main() {
    float height = dot(plane_normal, eye - plane_point);
    float approach = -dot(plane_normal, ray_through(gl_FragCoord.xy));
    if (approach <= 0.0 || height <= near_depth * approach) discard;
    out_depth = height / approach;
    out_surface = surface_of(plane_normal);
    gl_FragDepth = buffer_depth(out_depth);
}
