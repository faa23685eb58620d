#include "sim/hessian.h"
#include "sim/step.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>

#include <bit>

using namespace firn;

namespace {

constexpr double h = 0.1;
const SnowModel<double> snow = model(Snow{});

/// Some particles in a lump, deformed and moving at random, with the grid under them.
template <Weights kind> struct Lump {
    Particles<double> ps;
    Grid<double> grid;
    std::vector<SnowModel<double>> materials{snow};

    explicit Lump(std::size_t n = 43) {
        RandomInput random;
        ps.n = n;
        ps.x.resize(n), ps.v.resize(n), ps.Fe.resize(n), ps.Jp.resize(n), ps.tau.resize(n), ps.C.resize(n);
        ps.m.resize(n), ps.V0.resize(n), ps.id.resize(n);
        for (std::size_t p = 0; p < n; ++p) {
            const Vec3d x = 0.25 * random.vector(), v = random.vector();
            const Mat3d Fe = random.rotation() * random.deformation(0.01), C = random.matrix();
            for (int a = 0; a < 3; ++a) ps.x.at(p, a) = x(a), ps.v.at(p, a) = v(a);
            for (int k = 0; k < 9; ++k) ps.Fe.at(p, k) = Fe(k), ps.C.at(p, k) = C(k);
            ps.Jp.at(p) = 0.9 + 0.01 * double(p % 10);
            ps.m.at(p) = 1 + std::abs(random.number()), ps.V0.at(p) = 1e-3 * ps.m.at(p);
            ps.id[p] = static_cast<std::uint32_t>(p);
            set_stress(p);
        }
        grid.h = h;
        const Blocks unsorted = arrange(runs<kind>(ps, h), n, BSpline<kind>::width);
        ps.for_each_field([&](auto& field) { std::decay_t<decltype(field)> spare; field.permute(unsorted.order, spare); });
        grid.blocks = arrange(runs<kind>(ps, h), n, BSpline<kind>::width);
    }
    Lame<double> lame(std::size_t p) const { return hardened(snow, ps.Jp.at(p)); }
    void set_stress(std::size_t p) {
        const Elastic<double> e = elastic(matrix_of(ps.Fe, p));
        const auto tau = upper_triangle(Mat3d(stress(e, lame(p)) * e.F.transpose()));
        for (int i = 0; i < 6; ++i) ps.tau.at(p, i) = tau(i);
    }
    Vec3d position(std::size_t node) const {
        for (const GridBlock& b : grid.blocks.grid_blocks) {
            std::size_t i = b.first;
            for (int bit = 0; bit < 64; ++bit)
                if ((b.nodes >> bit & 1) != 0 && i++ == node) return grid.position(b, bit);
        }
        throw std::out_of_range("node");
    }
    /// Nodes that carry mass.
    std::vector<std::size_t> active() const {
        std::vector<std::size_t> a;
        for (std::size_t i = 0; i < grid.size(); ++i) if (grid.nodes[i][3] > 0) a.push_back(i);
        return a;
    }
    /// Φ after every node i has moved by u_i: Σ_p V_p⁰ Ψ((I + Σ_i u_i ∇w_ipᵀ) F_E).              report, (1)
    double potential(const NodeField<double>& u) const {
        double sum = 0;
        for (const ParticleBlock& b : grid.blocks.particle_blocks) {
            Tile<NodeVector<double>, BSpline<kind>::width> tile;
            tile.load(grid.blocks, b, u.at);
            for (std::uint32_t p = b.begin; p < b.end; ++p) {
                const auto i = interpolate<kind, Transfer::flip>(tile, b, Stencil<double, kind>(vector_of(ps.x, p), h));
                Mat3d gradient;
                for (int k = 0; k < 9; ++k) gradient(k) = i.d[k / 3][k % 3];
                const Mat3d F = (Mat3d::Identity() + gradient) * matrix_of(ps.Fe, p);
                sum += ps.V0.at(p) * energy_density(elastic(F), lame(p));
            }
        }
        return sum;
    }
    NodeField<double> still() const { return NodeField<double>(grid.size()); }
    NodeField<double> random_motion(RandomInput& random) const {
        NodeField<double> u = still();
        for (auto& a : u.at) a = NodeVector<double>::of(random.number(), random.number(), random.number(), 0);
        return u;
    }
};

/// With forces at its nodes, and their derivatives.
template <Weights kind> struct StiffLump : Lump<kind> {
    Elements<double, kind> elements;
    Hessian<double, kind> hessian;
    StiffLump() : Lump<kind>(with_forces()), elements(this->ps, this->grid, this->materials), hessian(elements) {}
    static Lump<kind> with_forces() {
        Lump<kind> lump;
        rasterize_with_forces<kind, Transfer::flip>(lump.ps, lump.grid);
        return lump;
    }
};

double dot(const NodeField<double>& a, const NodeField<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.at.size(); ++i) for (int c = 0; c < 3; ++c) sum += a.at[i][c] * b.at[i][c];
    return sum;
}

template <Weights kind, Transfer transfer> void check_conservation() {
    Lump<kind> lump;
    const Particles<double>& ps = lump.ps;
    rasterize_with_forces<kind, transfer>(ps, lump.grid);
    double m_p = 0, m_i = 0;
    Vec3d p_p = Vec3d::Zero(), p_i = p_p, L_p = p_p, L_i = p_p, force = p_p, torque = p_p;
    for (std::size_t p = 0; p < ps.n; ++p) {
        const double m = ps.m.at(p);
        const Mat3d C = matrix_of(ps.C, p);
        m_p += m, p_p += m * vector_of(ps.v, p), L_p += m * vector_of(ps.x, p).cross(vector_of(ps.v, p));
        if (transfer == Transfer::apic)
            L_p += m * BSpline<kind>::second_moment * h * h * Vec3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
    }
    double largest = 0;
    for (std::size_t i = 0; i < lump.grid.size(); ++i) {
        const auto& n = lump.grid.nodes[i];
        const Vec3d mv(n[0], n[1], n[2]), f(n[4], n[5], n[6]), x = lump.position(i);
        m_i += n[3], p_i += mv, L_i += x.cross(mv), force += f, torque += x.cross(f);
        largest = std::max(largest, f.norm());
    }
    CHECK(m_i == Approx(m_p).epsilon(1e-13));
    CHECK((p_i - p_p).norm() < 1e-12 * m_p);
    CHECK((L_i - L_p).norm() < 1e-12 * m_p);
    CHECK(largest > 1);
    CHECK(force.norm() < 1e-12 * largest);      // internal forces sum to zero,
    CHECK(torque.norm() < 1e-12 * largest);     // and so do their moments
}

template <Weights kind> void check_derivatives() {
    const StiffLump<kind> lump;
    const Hessian<double, kind>& hessian = lump.hessian;
    RandomInput random;
    const std::vector<std::size_t> active = lump.active();
    for (int n = 0; n < 30; ++n) {
        const std::size_t i = active[random.bits() % active.size()];
        const int c = n % 3;
        const double e = 1e-6 * h;
        NodeField<double> u = lump.still();
        u.at[i].lanes[c] = e;
        const double ahead = lump.potential(u);
        u.at[i].lanes[c] = -e;
        const double slope = (ahead - lump.potential(u)) / (2 * e);
        REQUIRE(lump.grid.nodes[i][4 + c] == Approx(-slope).margin(1e-4));  // forces here are about 1e2
    }
    for (int n = 0; n < 5; ++n) {
        const NodeField<double> a = lump.random_motion(random), b = lump.random_motion(random);
        NodeField<double> Ha, Hb;
        hessian(a, Ha), hessian(b, Hb);
        REQUIRE(dot(a, Hb) == Approx(dot(b, Ha)).epsilon(1e-12));
        // Second difference of Φ along a: error of the scheme about 1e-6 of it.
        const double e = 1e-4 * h;
        NodeField<double> forth = lump.still(), back = forth;
        forth.axpy(e, a), back.axpy(-e, a);
        const double curvature = (lump.potential(forth) - 2 * lump.potential(lump.still()) + lump.potential(back)) / (e * e);
        REQUIRE(dot(a, Ha) == Approx(curvature).epsilon(1e-3));
    }
}

/// (3) and (4): Φ does not see translations, so that H (1, 1, …) = 0 and, H being symmetric, force differentials
/// sum to zero; nor turns, so that to first order the forces turn along: H (ω × x_i) = −ω × f_i.
template <Weights kind> void check_invariance() {
    const StiffLump<kind> lump;
    const Hessian<double, kind>& hessian = lump.hessian;
    RandomInput random;
    const Vec3d a = random.vector(), omega = random.vector();
    NodeField<double> shift = lump.still(), turn = shift;
    for (const std::size_t i : lump.active()) {
        const Vec3d r = omega.cross(lump.position(i));
        shift.at[i] = NodeVector<double>::of(a(0), a(1), a(2), 0);
        turn.at[i] = NodeVector<double>::of(r(0), r(1), r(2), 0);
    }
    NodeField<double> of_shift, of_turn, of_any;
    hessian(shift, of_shift), hessian(turn, of_turn), hessian(lump.random_motion(random), of_any);
    Vec3d sum = Vec3d::Zero();
    double largest = 0, largest_force = 0;
    for (const std::size_t i : lump.active()) {
        const auto& n = lump.grid.nodes[i];
        const Vec3d f(n[4], n[5], n[6]), u(of_any.at[i][0], of_any.at[i][1], of_any.at[i][2]);
        sum += u, largest = std::max(largest, u.norm()), largest_force = std::max(largest_force, f.norm());
    }
    REQUIRE(largest > 1);
    REQUIRE(largest_force > 1);
    CHECK(sum.norm() < 1e-12 * largest);
    for (const std::size_t i : lump.active()) {
        const auto& n = lump.grid.nodes[i];
        const Vec3d f(n[4], n[5], n[6]);
        REQUIRE(Vec3d(of_shift.at[i][0], of_shift.at[i][1], of_shift.at[i][2]).norm() < 1e-12 * largest * a.norm());
        REQUIRE((Vec3d(of_turn.at[i][0], of_turn.at[i][1], of_turn.at[i][2]) + omega.cross(f)).norm() < 1e-12 * largest);
    }
}

}  // namespace

TEST_CASE("mass, momentum and angular momentum survive the way to the grid; internal forces cancel", "[transfer]") {
    check_conservation<Weights::cubic, Transfer::flip>();
    check_conservation<Weights::quadratic, Transfer::apic>();
    check_conservation<Weights::cubic, Transfer::apic>();
}

TEST_CASE("f is minus the gradient of the potential, and the Hessian product its second derivative", "[transfer]") {
    check_derivatives<Weights::cubic>();
    check_derivatives<Weights::quadratic>();
}

TEST_CASE("force differentials cancel, a translation makes none, and a turn makes what turns the forces", "[transfer]") {
    check_invariance<Weights::cubic>();
    check_invariance<Weights::quadratic>();
}

TEST_CASE("deep inside a regular lattice the grid's volume is the sampled one, at a face twice it", "[transfer]") {
    // Two particles a cell along each axis; step 2's ρ_p is ρ₀ deep inside and ρ₀/2 at a flat free surface.
    Particles<double> ps;
    const int n = 24;
    ps.n = n * n * n;
    ps.x.resize(ps.n), ps.v.resize(ps.n), ps.Fe.resize(ps.n), ps.Jp.resize(ps.n), ps.tau.resize(ps.n);
    ps.m.resize(ps.n), ps.V0.resize(ps.n), ps.id.resize(ps.n);
    for (std::size_t p = 0; p < ps.n; ++p) {
        const Vec3d x = h / 2 * Vec3d(double(p % n) + 0.5, double(p / n % n) + 0.5, double(p / n / n) + 0.5);
        for (int a = 0; a < 3; ++a) ps.x.at(p, a) = x(a);
        ps.m.at(p) = 1;
    }
    Grid<double> grid;
    grid.h = h;
    const Blocks unsorted = arrange(runs<Weights::cubic>(ps, h), ps.n, 4);
    ps.for_each_field([&](auto& f) { std::decay_t<decltype(f)> spare; if (!f.empty()) f.permute(unsorted.order, spare); });
    grid.blocks = arrange(runs<Weights::cubic>(ps, h), ps.n, 4);
    rasterize_with_forces<Weights::cubic, Transfer::flip>(ps, grid);
    set_volumes<Weights::cubic>(ps, grid);
    const double expected = h * h * h / 8;
    for (std::size_t p = 0; p < ps.n; ++p) {
        const Vec3d x = vector_of(ps.x, p) / h;
        const double depth = std::min(x.minCoeff(), (Vec3d::Constant(n / 2) - x).minCoeff());
        if (depth > 3) REQUIRE(ps.V0.at(p) == Approx(expected).epsilon(1e-3));
        const Vec3d inner = (x - Vec3d::Constant(n / 4.0)).cwiseAbs();
        if (depth < 0.3 && inner.y() < 2 && inner.z() < 2)
            REQUIRE(ps.V0.at(p) == Approx(1.63 * expected).epsilon(0.1));   // 1/0.61 a quarter of a cell below
    }
}

TEST_CASE("blocks keep the particles' order within them, and link them to every node that a stencil reaches", "[transfer]") {
    const Vec3i a(0, 0, 0), b(-3, 7, 2);
    const NodeSet corner = node_bit(0, 0, 0), far = node_bit(3, 3, 3);
    const std::vector<Run> runs{{a, 0, 2, corner}, {b, 2, 5, corner}, {a, 5, 6, far}};
    const Blocks blocks = arrange(runs, 6, 3);
    REQUIRE(blocks.particle_blocks.size() == 2);
    CHECK(blocks.order == std::vector<std::uint32_t>{2, 3, 4, 0, 1, 5});    // b comes first: −3 < 0
    CHECK(blocks.particle_blocks[1].begin == 3);
    CHECK(blocks.nodes == 3 * 27);                                 // of a: {0…2}³ and {3…5}³, which do not meet
    CHECK(blocks.grid_blocks.size() == 1 + 8);
    const Grid<double> grid{1, blocks, {}};
    for (const ParticleBlock& block : blocks.particle_blocks) {
        std::vector<Vec3i> reached;
        for (std::uint32_t l = block.first_link; l < block.last_link; ++l) {
            const Link& link = blocks.links[l];
            const int at = static_cast<int>(link.at);
            const Vec3i x = 4 * block.coordinates + Vec3i(at / 36, at / 6 % 6, at % 6);
            const auto owner = std::find_if(blocks.grid_blocks.begin(), blocks.grid_blocks.end(), [&](const GridBlock& g) {
                return link.node >= g.first && link.node < g.first + std::popcount(g.nodes); });
            REQUIRE(owner != blocks.grid_blocks.end());
            NodeSet left = owner->nodes;
            for (std::uint32_t n = owner->first; n < link.node; ++n) left &= left - 1;
            CHECK(grid.position(*owner, std::countr_zero(left)) == x.cast<double>());
            reached.push_back(x);
        }
        CHECK(reached.size() == (block.coordinates == a ? 54u : 27u));
    }
    CHECK(arrange({{b, 0, 3, corner}, {a, 3, 6, corner}}, 6, 3).order.empty());
    BlockMap map(1);
    for (int i = 0; i < 5000; ++i) REQUIRE(map.number_of(Vec3i(i, -i, 3 * i)) == std::uint32_t(i));
    for (int i = 0; i < 5000; ++i) REQUIRE(map.number_of(Vec3i(i, -i, 3 * i)) == std::uint32_t(i));
}
