out vec4 out_light;
void main() {
    out_light = vec4(0.02, 0.05, 0.12, 1.0);
}
