const int lens_block = 16;          // samples along an edge of what is searched for discs as one
uniform float aperture;            // diameter [m]
uniform float focus;               // [m]

// Radius of the disc over which a lens spreads a point at that depth, in samples:  A |d − f| / (2 d f tan).
float blur_at(float depth) { return 0.5 * aperture * abs(depth - focus) / (depth * focus * sample_tan); }
