#pragma once
#include "sim/settings.h"

#include <algorithm>
#include <vector>

namespace firn {

/// φ(x, t) [m] and n = ∇φ of a collider that has moved for t seconds.
inline double signed_distance(const Collider& c, const Vec3d& x, double t) {
    return signed_distance(c.shape, x - t * c.velocity);
}
inline Vec3d outward_normal(const Collider& c, const Vec3d& x, double t) {
    return outward_normal(c.shape, x - t * c.velocity);
}
/// Whether any collider comes within `radius` of x [m].
inline bool near(const std::vector<Collider>& colliders, const Vec3d& x, double radius, double t) {
    return std::any_of(colliders.begin(), colliders.end(),
                       [&](const Collider& c) { return signed_distance(c, x, t) <= radius; });
}

/// What contact did to a velocity, and what of it the solve may not change.
struct Contact {
    Vec3d v;                        ///< velocity after contact [m/s].
    enum class Fixes { nothing, normal, everything } fixes;
};

/// Contact of a point inside a body (φ ≤ 0) with outward normal n; v_rel = v − v_co, v_n = v_rel·n.
///   sticky:              v ← v_co
///   v_n ≥ 0:             nothing, the point is leaving
///   ‖v_t‖ ≤ −μ v_n:      v_rel ← 0, the point sticks to the body
///   else                 v_rel ← v_t + μ v_n v_t / ‖v_t‖, Coulomb's friction                paper, sec. 8
Contact collide(const Vec3d& v, const Vec3d& n, const Collider&);

/// What all colliders together did to a velocity.
struct Collided {
    Vec3d v;                        ///< velocity afterwards [m/s].
    Mat3d free;                     ///< projector onto the changes that the solve may still make; I: all.
    bool touched;                   ///< a contact fixed something.
};

/// All colliders in their order, at the point x and the time t [s].
Collided collide(const Vec3d& x, const Vec3d& v, const std::vector<Collider>&, double t);

/// A node's velocities in one step [m/s].
struct NodeMotion {
    Vec3d before;                   ///< vⁿ
    Vec3d after;                    ///< what meets the bodies: v*.
    Vec3d pressed{0, 0, 0};         ///< Δt f/m, of stresses alone.
    double flip_blend = 1;          ///< α [1]: PIC's share feels that the node was stopped.
};

/// Contact that bears what forces push into the body, and no more. With d = Δt (f/m + g), along the normal n of a body
/// that v*_n < 0 would enter or f_n < 0 presses on:
///   v*_n ← 0, so that snow is strained as the body strains it;  v_nⁿ ← −max(0, d_n), so that FLIP's particles feel
///   v* − vⁿ = max(0, d_n), and not that the node was stopped: what stops them is the stress of that strain
///   v_t ← as in `collide`, pressed by what snow feels along n: −d_n − (1−α) v_nⁿ, if that is positive
/// In a sticky body v* and vⁿ ← v_co. For Δt → 0 the powers of stresses at a node, f·v of the strain and of the particles,
/// are equal: no energy is lost. The law of `collide` takes v_nⁿ from the particles at every step, however short, through
/// however small a weight.
struct NodeCollided : Collided {
    Vec3d before;                   ///< vⁿ as FLIP has to see it [m/s].
};
NodeCollided collide_elastic(const Vec3d& x, NodeMotion, const std::vector<Collider>&, double t);

/// A node of Newton's step, with what bodies give it over the step: the impulse r. The laws of contact hold of r and v if
/// contact makes v of the trial v − r/D, whatever D > 0. [m/s]
struct Reaction {
    Vec3d v;                        ///< v − r/D
    Vec3d before;                   ///< vⁿ
    Vec3d d;                        ///< Δt (f/m + g)
    double share;                   ///< α m/D [1] under elastic contact, 0 under the paper's.
};
struct Judged : Collided {
    Vec3d body;                     ///< velocity of the last body that touched the node [m/s].
};
/// Contact of a trial velocity. Friction is of the load that snow feels: under elastic contact α m (−max(0, d_n) − v_nⁿ)
/// of r_n is what FLIP does not see.
Judged judge(const Vec3d& x, const Reaction&, const std::vector<Collider>&, double t);
/// vⁿ as FLIP has to see it where elastic contact holds what is not free; see `collide_elastic`.
Vec3d before_contact(const Vec3d& x, Vec3d before, const Vec3d& d, const Mat3d& free, const std::vector<Collider>&, double t);

}  // namespace firn
