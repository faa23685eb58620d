flat in float thickness;
out vec4 out_thickness;

void main() {
    vec2 d = gl_PointCoord * 2.0 - 1.0;
    float inside = max(1.0 - dot(d, d), 0.0);
    out_thickness = vec4(thickness * inside * inside);
}
