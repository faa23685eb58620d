void main() { out_light = vec4(develop(sky(normalize(ray_through(gl_FragCoord.xy)))), 1.0); }
