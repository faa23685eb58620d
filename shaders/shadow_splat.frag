// A square of the same area as the ball's disc: two to four texels wide, it is as round, and software need not ask.
void main() {}
