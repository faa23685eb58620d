#include "sim/collision.h"

#include <algorithm>

namespace firn {

Contact collide(const Vec3d& v, const Vec3d& n, const Collider& c) {
    if (c.contact == ContactLaw::sticky) return {c.velocity, Contact::Fixes::everything};
    const Vec3d v_rel = v - c.velocity;
    const double v_n = v_rel.dot(n);
    if (v_n >= 0) return {v, Contact::Fixes::nothing};
    const Vec3d v_t = v_rel - v_n * n;
    const double speed = v_t.norm();
    if (speed <= -c.friction * v_n) return {c.velocity, Contact::Fixes::everything};
    return {v_t + c.friction * v_n / speed * v_t + c.velocity, Contact::Fixes::normal};
}

namespace {

/// Takes from r.free what contact fixed.
void fix(Collided& r, Contact::Fixes fixes, const Vec3d& n) {
    if (fixes == Contact::Fixes::nothing) return;
    r.touched = true;
    if (fixes == Contact::Fixes::everything) {
        r.free.setZero();
    } else if (const Vec3d m = r.free * n; m.squaredNorm() > 1e-12) {
        r.free -= m * m.transpose() / m.squaredNorm();  // without n's direction in what was free still
    }
}

/// What elastic contact adds to vⁿ along n: −max(0, d_n) − v_nⁿ, where v_n ≤ 0 afterwards.
double unfelt(const Vec3d& before, double d_n, const Vec3d& n, const Collider& c) {
    const double v_n = (before - c.velocity).dot(n);
    return -(v_n + std::clamp(d_n, 0.0, std::max(0.0, -v_n)));
}

}  // namespace

Collided collide(const Vec3d& x, const Vec3d& v, const std::vector<Collider>& colliders, double t) {
    Collided r{v, Mat3d::Identity(), false};
    for (const Collider& c : colliders) {
        if (signed_distance(c, x, t) > 0) continue;
        const Vec3d n = outward_normal(c, x, t);
        const Contact contact = collide(r.v, n, c);
        r.v = contact.v;
        fix(r, contact.fixes, n);
    }
    return r;
}

NodeCollided collide_elastic(const Vec3d& x, NodeMotion v, const std::vector<Collider>& colliders, double t) {
    NodeCollided r{{v.after, Mat3d::Identity(), false}, v.before};
    for (const Collider& c : colliders) {
        if (signed_distance(c, x, t) > 0) continue;
        const Vec3d n = outward_normal(c, x, t);
        if (c.contact != ContactLaw::sticky && (r.v - c.velocity).dot(n) >= 0 && v.pressed.dot(n) >= 0) continue;
        const double d_n = (r.v - r.before).dot(n), v_n = (r.before - c.velocity).dot(n);
        const Vec3d along = r.v - (r.v - c.velocity).dot(n) * n;
        // What is left to meet the body is v_t, and the load on it.
        const double felt = d_n + (1 - v.flip_blend) * v_n;
        const Contact contact = collide(along + std::min(0.0, felt) * n, n, c);
        r.v = contact.fixes == Contact::Fixes::nothing ? along : contact.v;
        r.before = c.contact == ContactLaw::sticky ? c.velocity : Vec3d(r.before + unfelt(r.before, d_n, n, c) * n);
        fix(r, contact.fixes == Contact::Fixes::nothing ? Contact::Fixes::normal : contact.fixes, n);
    }
    return r;
}

Judged judge(const Vec3d& x, const Reaction& a, const std::vector<Collider>& colliders, double t) {
    Judged r{{a.v, Mat3d::Identity(), false}, {0, 0, 0}};
    for (const Collider& c : colliders) {
        if (signed_distance(c, x, t) > 0) continue;
        const Vec3d n = outward_normal(c, x, t);
        const double pressing = (r.v - c.velocity).dot(n);
        if (c.contact != ContactLaw::sticky && pressing >= 0) continue;
        const Vec3d along = r.v - pressing * n;
        const double felt = pressing + a.share * unfelt(a.before, a.d.dot(n), n, c);
        const Contact contact = collide(along + std::min(0.0, felt) * n, n, c);
        r.v = contact.fixes == Contact::Fixes::nothing ? along : contact.v, r.body = c.velocity;
        fix(r, contact.fixes == Contact::Fixes::nothing ? Contact::Fixes::normal : contact.fixes, n);
    }
    return r;
}

Vec3d before_contact(const Vec3d& x, Vec3d before, const Vec3d& d, const Mat3d& free, const std::vector<Collider>& colliders, double t) {
    for (const Collider& c : colliders) {
        if (signed_distance(c, x, t) > 0) continue;
        const Vec3d n = outward_normal(c, x, t);
        if ((free * n).norm() > 1e-3) continue;
        before = c.contact == ContactLaw::sticky ? c.velocity : Vec3d(before + unfelt(before, d.dot(n), n, c) * n);
    }
    return before;
}

}  // namespace firn
