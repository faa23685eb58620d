#pragma once
#include "app/numbers.h"
#include "app/scene.h"

#include <array>

// Every key of a scene, once. `describe(visitor, object)` shows the visitor each key of the object with its
// unit, range and meaning; the default is the member's value in a fresh object. Three visitors use it: the
// reader of YAML, the writer of resolved scenes, and the writer of the JSON Schema.
//
// A visitor has
//   key(Key, member)              for numbers, texts, vectors, choices, objects and collections of them
//   key(Key, Shape&, ShapeUse)    for shapes
//   either(Key, Shape&, Key, std::string& file)     for a body's two origins
//   any_of(name, help, object)    for each kind of shape

namespace firn {

struct Key {
    const char* name;
    const char* help;
    const char* unit = "";
    Range range = {};
    bool required = false;
};

template <class E> struct Choice { const char* name; E value; };

inline constexpr auto choices(Integrator) {
    return std::array{Choice<Integrator>{"explicit", Integrator::explicit_euler},
                      Choice<Integrator>{"semi_implicit", Integrator::semi_implicit},
                      Choice<Integrator>{"newton", Integrator::newton}};
}
inline constexpr auto choices(LinearSolver) {
    return std::array{Choice<LinearSolver>{"conjugate_gradient", LinearSolver::conjugate_gradient},
                      Choice<LinearSolver>{"conjugate_residual", LinearSolver::conjugate_residual},
                      Choice<LinearSolver>{"minres", LinearSolver::minres}};
}
inline constexpr auto choices(Defaults) {
    return std::array{Choice<Defaults>{"firn", Defaults::firn}, Choice<Defaults>{"paper", Defaults::paper}};
}
inline constexpr auto choices(Stiff) {
    return std::array{Choice<Stiff>{"weighted", Stiff::weighted}, Choice<Stiff>{"all", Stiff::all}};
}
inline constexpr auto choices(Transfer) {
    return std::array{Choice<Transfer>{"flip", Transfer::flip}, Choice<Transfer>{"apic", Transfer::apic}};
}
inline constexpr auto choices(Weights) {
    return std::array{Choice<Weights>{"cubic", Weights::cubic},
                      Choice<Weights>{"quadratic", Weights::quadratic}};
}
inline constexpr auto choices(Precision) {
    return std::array{Choice<Precision>{"float", Precision::single},
                      Choice<Precision>{"double", Precision::twofold}};
}
inline constexpr auto choices(InitialVolume) {
    return std::array{Choice<InitialVolume>{"grid", InitialVolume::grid},
                      Choice<InitialVolume>{"sampled", InitialVolume::sampled}};
}
inline constexpr auto choices(NodeContact) {
    return std::array{Choice<NodeContact>{"inelastic", NodeContact::inelastic},
                      Choice<NodeContact>{"elastic", NodeContact::elastic}};
}
inline constexpr auto choices(Sampling) {
    return std::array{Choice<Sampling>{"poisson_disk", Sampling::poisson_disk},
                      Choice<Sampling>{"lattice", Sampling::lattice},
                      Choice<Sampling>{"random", Sampling::random}};
}
inline constexpr auto choices(ContactLaw) {
    return std::array{Choice<ContactLaw>{"slide", ContactLaw::slide},
                      Choice<ContactLaw>{"sticky", ContactLaw::sticky}};
}
inline constexpr auto choices(Quality) {
    return std::array{Choice<Quality>{"draft", Quality::draft}, Choice<Quality>{"preview", Quality::preview},
                      Choice<Quality>{"final", Quality::final}};
}

inline constexpr auto choices(Colour) {
    return std::array{Choice<Colour>{"snow", Colour::snow},
                      Choice<Colour>{"speed", Colour::speed},
                      Choice<Colour>{"density", Colour::density},
                      Choice<Colour>{"compression", Colour::compression},
                      Choice<Colour>{"stress", Colour::stress},
                      Choice<Colour>{"body", Colour::body},
                      Choice<Colour>{"particle-id", Colour::particle_id},
                      Choice<Colour>{"sleeping", Colour::sleeping}};
}
inline constexpr auto choices(Look) {
    return std::array{Choice<Look>{"auto", Look::automatic}, Choice<Look>{"snow", Look::snow},
                      Choice<Look>{"ice", Look::ice},        Choice<Look>{"soil", Look::soil},
                      Choice<Look>{"wood", Look::wood},      Choice<Look>{"tiles", Look::tiles},
                      Choice<Look>{"concrete", Look::concrete}, Choice<Look>{"metal", Look::metal},
                      Choice<Look>{"glass", Look::glass}};
}

/// The word that stands for the value in a scene.
template <class E> requires std::is_enum_v<E> constexpr const char* name_of(E value) {
    for (const auto& choice : choices(value))
        if (choice.value == value) return choice.name;
    return "";
}

/// Where a shape stands decides which kinds it may be of.
enum class ShapeUse {
    solid,      ///< is filled with snow: bounded.
    cut,        ///< is taken away from a solid: any.
    collider,   ///< plane, sphere, box, cylinder, capsule: those with an exact distance.
};

inline constexpr Range coordinates = within(1e6), speeds = within(1e6), lengths = above(0).up_to(1e6);

template <class V> void describe(V& v, Sphere& s) {
    v.key({"center", "where its middle is", "m", coordinates}, s.center);
    v.key({"radius", "distance of the surface from the centre", "m", lengths, true}, s.radius);
}
template <class V> void describe(V& v, Plane& s) {
    v.key({"point", "any point of the plane", "m", coordinates}, s.point);
    v.key({"normal", "points out of the solid half space; any length but 0", "", coordinates}, s.normal);
}
template <class V> void describe(V& v, Box& s) {
    v.key({"center", "where its middle is", "m", coordinates}, s.center);
    v.key({"size", "full edge lengths along x, y, z", "m", lengths, true}, s.size);
}
template <class V> void describe(V& v, Cylinder& s) {
    v.key({"from", "centre of one end", "m", coordinates, true}, s.from);
    v.key({"to", "centre of the other end", "m", coordinates, true}, s.to);
    v.key({"radius", "distance of the surface from the axis", "m", lengths, true}, s.radius);
}
template <class V> void describe(V& v, Capsule& s) {
    v.key({"from", "centre of one round end", "m", coordinates, true}, s.from);
    v.key({"to", "centre of the other round end", "m", coordinates, true}, s.to);
    v.key({"radius", "distance of the surface from the axis", "m", lengths, true}, s.radius);
}
template <class V> void describe(V& v, Ellipsoid& s) {
    v.key({"center", "where its middle is", "m", coordinates}, s.center);
    v.key({"radii", "half axes along x, y, z", "m", lengths, true}, s.radii);
}

/// Shows the visitor each kind of shape that may stand there, as an object of its own.
template <class V> void describe_kinds(V& v, ShapeUse use) {
    v.kind("sphere", "a ball", Sphere{});
    if (use != ShapeUse::solid) v.kind("plane", "the half space behind a plane", Plane{});
    v.kind("box", "a box along the axes", Box{});
    v.kind("cylinder", "a cylinder with flat ends", Cylinder{});
    v.kind("capsule", "a cylinder with round ends", Capsule{});
    if (use == ShapeUse::collider) return;
    v.kind("ellipsoid", "an ellipsoid along the axes", Ellipsoid{});
    v.kind("union", "everything that is in at least one of these shapes", Union{});
    v.kind("difference", "the first shape without the others", Difference{});
}

template <class V> void describe(V& v, Solver& s) {
    v.key({"defaults", "whose values stand for what is not given here; paper: the step as it was published"}, s.defaults);
    v.key({"integrator", "explicit, the paper's semi-implicit step, or fully implicit by Newton's method"}, s.integrator);
    v.key({"beta", "semi_implicit: 0.5 trapezoidal, 1 backward Euler", "", above(0).up_to(1)}, s.beta);
    v.key({"stiff", "semi_implicit: weighted makes a particle as implicit as its stiffness asks for, all makes each wholly so"}, s.stiff);
    v.key({"stiff_limit", "speed of sound times dt over grid_spacing up to which a particle is explicit; auto: all that is stable",
           "", above(0).up_to(10)}, s.stiff_limit);
    v.key({"strain_limit", "greatest strain of an automatic time step", "", above(0).up_to(0.5)}, s.strain_limit);
    v.key({"dt", "time step, or auto: bounded by the flow, and by the wave speed when explicit", "s",
           above(0).up_to(1e3)}, s.dt);
    v.key({"max_dt", "upper bound of an automatic time step", "s", above(0).up_to(1e3)}, s.max_dt);
    v.key({"transfer", "how velocities go from particles to grid and back"}, s.transfer);
    v.either({"flip_damping", "rate at which the share of FLIP in a velocity goes over to PIC", "1/s", at_least(0).up_to(1e6)},
             s.flip_damping,
             {"flip_blend", "the paper's: share of FLIP in every step, however short; smaller steps damp more", "", at_least(0).up_to(1)},
             s.flip_blend);
    v.key({"weights", "shape functions of the grid"}, s.weights);
    v.key({"precision", "of particles and grid"}, s.precision);
    v.key({"initial_volume", "sampled: mass over density; grid: the paper's step 2, too large and so too stiff where snow ends"},
          s.initial_volume);
    v.key({"node_contact", "of FLIP's nodes with bodies. elastic: bears forces; inelastic: the paper's, brakes snow at every step, however short"},
          s.node_contact);
    v.key({"linear_solver", "of the implicit integrators; conjugate_gradient uses the stiffness of unstrained snow, the others that of strained snow"}, s.linear_solver);
    v.key({"tolerance", "relative residual of the solve", "", above(0).below(1)}, s.tolerance);
    v.key({"max_iterations", "of a linear solve", "", at_least(1).up_to(10000)}, s.max_iterations);
    v.key({"rest_speed", "snow that is slower for rest_time sleeps until something moves it; 0: never", "m/s",
           at_least(0).up_to(1e6)}, s.rest_speed);
    v.key({"rest_time", "how long snow must be slow before it sleeps; at least 2 rest_speed/|gravity|", "s", at_least(0).up_to(1e6)}, s.rest_time);
}

template <class V> void describe(V& v, Snow& s) {
    v.key({"E", "Young's modulus; higher is icier", "Pa", above(0).up_to(1e12)}, s.E);
    v.key({"nu", "Poisson's ratio", "", above(-1).below(0.5)}, s.nu);
    v.key({"xi", "hardening; higher is more brittle", "", at_least(0).up_to(1e4)}, s.xi);
    v.key({"theta_c", "critical compression; larger is chunky, smaller powdery", "", at_least(0).below(1)},
          s.theta_c);
    v.key({"theta_s", "critical stretch; very large is elastic", "", at_least(0).up_to(1e9)}, s.theta_s);
    v.key({"rho", "density at the start, of even snow", "kg/m^3", above(0).up_to(1e6)}, s.rho);
    v.key({"max_density", "of ice: snow is packed no denser, then it is elastic; 1e9 for the paper's endless packing",
           "kg/m^3", above(0).up_to(1e9)}, s.max_density);
}

template <class V> void describe(V& v, Lumps& l) {
    v.key({"size", "mean width of the largest, which are made of halves and quarters; some cells of the grid at least",
           "m", lengths, true}, l.size);
    v.key({"core", "J_P within the firmest; smaller is harder and denser", "", at_least(0.4).up_to(10)}, l.core);
    v.key({"seam", "J_P between lumps; larger is weaker", "", at_least(0.1).up_to(10)}, l.seam);
}

template <class V> void describe(V& v, SceneBody& b) {
    v.key({"material", "name of one of the materials; may be left out where there is one"}, b.material);
    v.either({"shape", "the solid that is filled with snow"}, b.shape,
             {"particles", "PLY file of particles, relative to this file"}, b.particles);
    v.key({"velocity", "at the start; added to a file's own", "m/s", speeds}, b.velocity);
    v.key({"angular_velocity", "at the start, about the centre of mass", "rad/s", speeds},
          b.angular_velocity);
    v.key({"particles_per_cell", "particles in a cell's volume of snow", "", at_least(1e-3).up_to(1000)},
          b.particles_per_cell);
    v.key({"sampling", "arrangement of the particles"}, b.sampling);
    v.key({"lumps", "snow packed unevenly, which breaks in chunks; left out: even"}, b.lumps);
}

template <class V> void describe(V& v, Solid& c) {
    v.key({"shape", "the solid that snow cannot enter", "", {}, true}, c.shape, ShapeUse::collider);
    v.key({"contact", "whether snow slides or sticks"}, c.contact);
    v.key({"friction", "Coulomb's coefficient for sliding", "", at_least(0).up_to(1e9)}, c.friction);
    v.key({"velocity", "constant", "m/s", speeds}, c.velocity);
    v.key({"look", "what it is drawn as; auto: a ground is snow, all else is concrete"}, c.look);
}

template <class V> void describe(V& v, CameraKey& k) {
    v.key({"time", "when the camera is there", "s", within(1e6), true}, k.time);
    v.key({"eye", "where the camera is", "m", coordinates, true}, k.eye);
    v.key({"target", "what it looks at", "m", coordinates, true}, k.target);
    v.key({"field_of_view", "vertical, in degrees", "degrees", above(0).below(180)}, k.field_of_view);
}

template <class V> void describe(V& v, Camera& c) {
    v.key({"eye", "where the camera is", "m", coordinates}, c.eye);
    v.key({"target", "what it looks at", "m", coordinates}, c.target);
    v.key({"field_of_view", "vertical, in degrees", "degrees", above(0).below(180)}, c.field_of_view);
    v.key({"aperture", "diameter of the lens; 0: all is sharp", "m", at_least(0).up_to(1e3)}, c.aperture);
    v.key({"focus", "distance that is sharp, or auto: the target's", "m", above(0).up_to(1e6)}, c.focus);
    v.key({"orbit", "turns the camera about the vertical through its target", "degrees/s", within(1e6)}, c.orbit);
    v.key({"keyframes", "a path that stands instead of eye, target and field_of_view"}, c.keyframes);
}

template <class V> void describe(V& v, Picture& p) {
    v.key({"width", "pixels", "", at_least(1).up_to(16384)}, p.width);
    v.key({"height", "pixels", "", at_least(1).up_to(16384)}, p.height);
    v.key({"quality", "the renderer's effort"}, p.quality);
    v.key({"sun_azimuth", "where the light comes from, from +x towards +z", "degrees", within(360)},
          p.sun_azimuth);
    v.key({"sun_elevation", "of the sun above the horizon", "degrees", within(90)}, p.sun_elevation);
    v.key({"exposure", "factor on the light", "", above(0).up_to(1000)}, p.exposure);
    v.key({"shutter", "how long it is open; spray is drawn along its way", "s", at_least(0).up_to(1e3)}, p.shutter);
    v.key({"motion_samples", "moments of that time that are averaged; 1 blurs spray alone", "", at_least(1).up_to(64)},
          p.motion_samples);
    v.key({"colour", "what the snow's colour shows"}, p.colour);
    v.key({"colour_min", "value at the colour map's lower end, or auto", "", within(1e15)}, p.colour_min);
    v.key({"colour_max", "value at the colour map's upper end, or auto", "", within(1e15)}, p.colour_max);
    v.key({"slice", "a plane; snow that its normal points to is cut away"}, p.slice);
    v.key({"grid_nodes", "draws the nodes of the cells that hold snow"}, p.grid_nodes);
    v.key({"overlay", "writes time, time step and number of particles into the picture"}, p.overlay);
}

template <class V> void describe(V& v, Scene& s) {
    v.key({"title", "what the scene shows; the file's name if left out"}, s.title);
    v.key({"frames", "pictures after the first; frame 0 is the start", "", at_least(0).up_to(1e7)}, s.frames);
    v.key({"fps", "frames a second of simulated time", "1/s", above(0).up_to(1e6)}, s.fps);
    v.key({"grid_spacing", "edge h of a grid cell; half of it means 8 times the particles", "m",
           at_least(1e-6).up_to(1e3), true},
          s.grid_spacing);
    v.key({"gravity", "acceleration", "m/s^2", within(1e6)}, s.gravity);
    v.key({"seed", "of the particles' arrangement", "", at_least(0).up_to(9007199254740992.0)}, s.seed);
    v.key({"solver", "the numbers that trade speed for accuracy"}, s.solver);
    v.key({"materials", "kinds of snow by name; left out: one, snow, with the defaults"}, s.materials);
    v.key({"bodies", "snow at the start", "", {}, true}, s.bodies);
    v.key({"colliders", "solids that snow cannot enter"}, s.colliders);
    v.key({"camera", "left out: one that frames the bodies and the ground under them"}, s.camera);
    v.key({"picture", "size and look of the pictures"}, s.picture);
}

}  // namespace firn
