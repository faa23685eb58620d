in vec3 world_normal;
in float depth;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_surface;

void main() {
    out_depth = depth;
    out_surface = surface_of(normalize(world_normal));
}
