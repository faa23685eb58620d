// Stands before every shader. Lengths in m; depth is the distance along the view's forward direction.

uniform vec3 eye;
uniform mat3 basis;          // columns right, up, forward
uniform vec2 samples;        // size of the buffers
uniform float sample_tan;    // width of a sample at unit depth
uniform float near_depth;
uniform mat4 projection;

// The depth buffer's value: 0 at the near plane, 1 at infinity.
float buffer_depth(float depth) { return 1.0 - near_depth / max(depth, near_depth); }

// From the eye through a sample; its part along forward is 1.
vec3 ray_through(vec2 sample_position) {
    return basis * vec3((sample_position - 0.5 * samples) * sample_tan, 1.0);
}

// 1 below the lower edge, 0 above the upper one.
float fading(float lower, float upper, float x) { return 1.0 - smoothstep(lower, upper, x); }

// How the surface buffer, of ten bits, holds a normal: 0 and ±1 exactly, so that what is level is level with every driver.
vec4 surface_of(vec3 normal) { return vec4((512.0 + 511.0 * normal) / 1023.0, 1.0); }
vec3 normal_of(vec4 surface) { return normalize(1023.0 / 511.0 * surface.xyz - 512.0 / 511.0); }
