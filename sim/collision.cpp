#include "sim/collision.h"

#include <algorithm>

namespace firn {

Contact collide(const Vec3d& v, const Vec3d& n, const Collider& c, const Vec3d& push) {
    if (c.contact == ContactLaw::sticky) return {c.velocity, Contact::Fixes::everything};
    const Vec3d v_rel = v - c.velocity;
    const double v_n = v_rel.dot(n) + std::min(0.0, push.dot(n));
    if (v_n >= 0) return {v, Contact::Fixes::nothing};
    const Vec3d v_t = v_rel - v_rel.dot(n) * n;
    const double speed = v_t.norm();
    if (speed <= -c.friction * v_n) return {c.velocity, Contact::Fixes::everything};
    return {v_t + c.friction * v_n / speed * v_t + c.velocity, Contact::Fixes::normal};
}

Collided collide(const Vec3d& x, const Vec3d& v, const std::vector<Collider>& colliders, double t,
                 const Vec3d& push) {
    Collided r{v, Mat3d::Identity(), false};
    for (const Collider& c : colliders) {
        if (signed_distance(c, x, t) > 0) continue;
        const Vec3d n = outward_normal(c, x, t);
        const Contact contact = collide(r.v, n, c, push);
        r.v = contact.v;
        if (contact.fixes == Contact::Fixes::nothing) continue;
        r.touched = true;
        if (contact.fixes == Contact::Fixes::everything) {
            r.free.setZero();
        } else if (const Vec3d m = r.free * n; m.squaredNorm() > 1e-12) {
            r.free -= m * m.transpose() / m.squaredNorm();  // without n's direction in what was free still
        }
    }
    return r;
}

}  // namespace firn
