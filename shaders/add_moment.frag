// Adds the light of one moment to that of the others.
uniform sampler2D light;
uniform float share;

out vec4 out_light;

void main() { out_light = vec4(share * texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb, 1.0); }
