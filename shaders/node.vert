// A node of the grid.
layout(location = 0) in vec3 position;
uniform float edge;                // samples along a pixel's edge

void main() {
    gl_Position = projection * vec4(position, 1.0);
    gl_PointSize = 2.0 * edge;
}
