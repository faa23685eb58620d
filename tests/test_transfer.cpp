#include "sim/hessian.h"
#include "sim/step.h"
#include "tests/random_matrices.h"
#include "tests/report.h"

#include <catch2/catch.hpp>

#include <bit>

using namespace firn;

namespace {

constexpr double h = 0.1;
const SnowModel<double> snow = model(Snow{});

/// Particles at x, in their blocks: `set` fills in the rest of particle p in its slot.
template <Weights kind, class F>
void place_particles(Particles<double>& ps, Grid<double>& grid, const std::vector<Vec3d>& x, F&& set) {
    Arrangement a = arrange<kind, double>(x.size(), h, [&](std::size_t p) { return x[p]; });
    ps.resize(a.groups);
    for (std::size_t p = 0; p < x.size(); ++p) {
        for (int c = 0; c < 3; ++c) ps.x.at(a.slots[p], c) = x[p](c);
        ps.id[a.slots[p]] = static_cast<std::uint32_t>(p);
        set(p, a.slots[p]);
    }
    grid.h = h;
    grid.blocks.link(std::move(a.blocks), BSpline<kind>::width);
}

/// Some particles in a heap, deformed and moving at random, with the grid under them.
template <Weights kind> struct Heap {
    Particles<double> ps;
    Grid<double> grid;
    std::vector<SnowModel<double>> materials{snow};

    explicit Heap(std::size_t n = 43) {
        RandomInput random;
        std::vector<Vec3d> x(n);
        for (Vec3d& x_p : x) x_p = 0.25 * random.vector();
        ps.affine = true;
        place_particles<kind>(ps, grid, x, [&](std::size_t p, std::size_t slot) {
            const Vec3d v = random.vector();
            const Mat3d Fe = random.rotation() * random.deformation(0.01), C = random.matrix();
            for (int a = 0; a < 3; ++a) ps.v.at(slot, a) = v(a);
            for (int k = 0; k < 9; ++k) ps.Fe.at(slot, k) = Fe(k), ps.C.at(slot, k) = C(k);
            ps.Jp.at(slot) = 0.9 + 0.01 * double(p % 10);
            ps.m.at(slot) = 1 + std::abs(random.number()), ps.V0.at(slot) = 1e-3 * ps.m.at(slot);
            const Mat3d tau = stress(elastic(Fe), lame(slot)) * Fe.transpose();
            const double numbers[] = {tau(0, 0), tau(0, 1), tau(0, 2), tau(1, 1), tau(1, 2), tau(2, 2)};
            for (int i = 0; i < 6; ++i) ps.tau.at(slot, i) = numbers[i];
        });
    }
    Lame<double> lame(std::size_t p) const { return hardened(snow, ps.Jp.at(p)); }
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
        Pages<Node<double>> moves(grid.size());
        for (std::size_t i = 0; i < grid.size(); ++i) moves[i] = Node<double>::of(u.at[i][0], u.at[i][1], u.at[i][2], 0, 0, 0, 0, 0);
        for (const ParticleBlock& b : grid.blocks.particle_blocks) {
            SlopedTile<Node<double>, BSpline<kind>::width> tile;
            tile.load(grid.blocks, b, moves);
            for (std::uint32_t n = 0; n < b.count; ++n) {
                Reach<double, kind, Transfer::flip> reach(vectors_of(ps.x, b.groups[n / lanes]), b, h);
                reach.sum_up_z();
                const auto i = interpolate(tile, reach, n % lanes);
                Mat3d gradient;
                for (int k = 0; k < 9; ++k) gradient(k) = i.d[k / 3][k % 3];
                const std::size_t slot = b.slot(n);
                const Mat3d F = (Mat3d::Identity() + gradient) * matrix_of(ps.Fe, slot);
                sum += ps.V0.at(slot) * energy_density(elastic(F), lame(slot));
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
template <Weights kind> struct StiffLump : Heap<kind> {
    Elements<double, kind> elements;
    Hessian<double, kind> hessian;
    StiffLump() : Heap<kind>(with_forces()), elements(this->ps, this->grid, this->materials, wholly()), hessian(elements, this->ps) {}
    static StiffnessLimits wholly() { return {Solver::paper(), {Snow{}}, h, 1}; }
    static Heap<kind> with_forces() {
        Heap<kind> heap;
        rasterize_with_forces<kind, Transfer::flip>(heap.ps, heap.grid);
        return heap;
    }
};

double dot(const NodeField<double>& a, const NodeField<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.at.size(); ++i) for (int c = 0; c < 3; ++c) sum += a.at[i][c] * b.at[i][c];
    return sum;
}

template <Weights kind, Transfer transfer> void check_conservation() {
    Heap<kind> heap;
    Particles<double>& ps = heap.ps;
    rasterize_with_forces<kind, transfer>(ps, heap.grid);
    double m_p = 0, m_i = 0;
    Vec3d p_p = Vec3d::Zero(), p_i = p_p, L_p = p_p, L_i = p_p, force = p_p, torque = p_p;
    heap.grid.blocks.for_each_particle([&](std::size_t p) {
        const double m = ps.m.at(p);
        const Mat3d C = matrix_of(ps.C, p);
        m_p += m, p_p += m * vector_of(ps.v, p), L_p += m * vector_of(ps.x, p).cross(vector_of(ps.v, p));
        if (transfer == Transfer::apic)
            L_p += m * BSpline<kind>::second_moment * h * h * Vec3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
    });
    double largest = 0;
    for (std::size_t i = 0; i < heap.grid.size(); ++i) {
        const auto& n = heap.grid.nodes[i];
        const Vec3d mv(n[0], n[1], n[2]), f(n[4], n[5], n[6]), x = heap.position(i);
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
    const StiffLump<kind> heap;
    const Hessian<double, kind>& hessian = heap.hessian;
    RandomInput random;
    const std::vector<std::size_t> active = heap.active();
    for (int n = 0; n < 30; ++n) {
        const std::size_t i = active[random.bits() % active.size()];
        const int c = n % 3;
        const double e = 1e-6 * h;
        NodeField<double> u = heap.still();
        u.at[i].lanes[c] = e;
        const double ahead = heap.potential(u);
        u.at[i].lanes[c] = -e;
        const double slope = (ahead - heap.potential(u)) / (2 * e);
        REQUIRE(heap.grid.nodes[i][4 + c] == Approx(-slope).margin(1e-4));  // forces here are about 1e2
    }
    for (int n = 0; n < 5; ++n) {
        const NodeField<double> a = heap.random_motion(random), b = heap.random_motion(random);
        NodeField<double> Ha, Hb;
        hessian(a, Ha), hessian(b, Hb);
        REQUIRE(dot(a, Hb) == Approx(dot(b, Ha)).epsilon(1e-12));
        // Second difference of Φ along a: error of the scheme about 1e-6 of it.
        const double e = 1e-4 * h;
        NodeField<double> forth = heap.still(), back = forth;
        forth.axpy(e, a), back.axpy(-e, a);
        const double curvature = (heap.potential(forth) - 2 * heap.potential(heap.still()) + heap.potential(back)) / (e * e);
        REQUIRE(dot(a, Ha) == Approx(curvature).epsilon(1e-3));
    }
}

/// (3) and (4): Φ does not see translations, so that H (1, 1, …) = 0 and, H being symmetric, force differentials
/// sum to zero; nor turns, so that to first order the forces turn along: H (ω × x_i) = −ω × f_i.
template <Weights kind> void check_invariance() {
    const StiffLump<kind> heap;
    const Hessian<double, kind>& hessian = heap.hessian;
    RandomInput random;
    const Vec3d a = random.vector(), omega = random.vector();
    NodeField<double> shift = heap.still(), turn = shift;
    for (const std::size_t i : heap.active()) {
        const Vec3d r = omega.cross(heap.position(i));
        shift.at[i] = NodeVector<double>::of(a(0), a(1), a(2), 0);
        turn.at[i] = NodeVector<double>::of(r(0), r(1), r(2), 0);
    }
    NodeField<double> of_shift, of_turn, of_any;
    hessian(shift, of_shift), hessian(turn, of_turn), hessian(heap.random_motion(random), of_any);
    Vec3d sum = Vec3d::Zero();
    double largest = 0, largest_force = 0;
    for (const std::size_t i : heap.active()) {
        const auto& n = heap.grid.nodes[i];
        const Vec3d f(n[4], n[5], n[6]), u(of_any.at[i][0], of_any.at[i][1], of_any.at[i][2]);
        sum += u, largest = std::max(largest, u.norm()), largest_force = std::max(largest_force, f.norm());
    }
    REQUIRE(largest > 1);
    REQUIRE(largest_force > 1);
    CHECK(sum.norm() < 1e-12 * largest);
    for (const std::size_t i : heap.active()) {
        const auto& n = heap.grid.nodes[i];
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
    const int n = 24;
    std::vector<Vec3d> x;
    for (int p = 0; p < n * n * n; ++p) x.push_back(h / 2 * Vec3d(p % n + 0.5, p / n % n + 0.5, p / n / n + 0.5));
    Particles<double> ps;
    Grid<double> grid;
    place_particles<Weights::cubic>(ps, grid, x, [&](std::size_t, std::size_t slot) { ps.m.at(slot) = 1; });
    rasterize_with_forces<Weights::cubic, Transfer::flip>(ps, grid);
    set_volumes<Weights::cubic>(ps, grid);
    const double expected = h * h * h / 8;
    grid.blocks.for_each_particle([&](std::size_t p) {
        const Vec3d X = vector_of(ps.x, p) / h;
        const double depth = std::min(X.minCoeff(), (Vec3d::Constant(n / 2) - X).minCoeff());
        if (depth > 3) REQUIRE(ps.V0.at(p) == Approx(expected).epsilon(1e-3));
        const Vec3d inner = (X - Vec3d::Constant(n / 4.0)).cwiseAbs();
        if (depth < 0.3 && inner.y() < 2 && inner.z() < 2)
            REQUIRE(ps.V0.at(p) == Approx(1.63 * expected).epsilon(0.1));   // 1/0.61 a quarter of a cell below
    });
}

TEST_CASE("blocks keep the particles' order within them, and link them to every node that a stencil reaches", "[transfer]") {
    const Vec3i a(0, 0, 0), b(-3, 7, 2);
    const auto on = [](const Vec3i& base) -> Vec3d { return base.cast<double>() + Vec3d::Constant(0.9); };
    const std::vector<Vec3d> positions{on(4 * a), on(4 * a), on(4 * b), on(4 * b), on(4 * b), on(4 * a + Vec3i(3, 3, 3))};
    Arrangement arrangement = arrange<Weights::quadratic, double>(6, 1, [&](std::size_t p) { return positions[p]; });
    CHECK(arrangement.groups == 2);
    CHECK(arrangement.slots == std::vector<std::uint32_t>{0, 1, 8, 9, 10, 2});
    Blocks blocks;
    blocks.link(std::move(arrangement.blocks), 3);
    REQUIRE(blocks.particle_blocks.size() == 2);
    CHECK(blocks.particle_blocks[0].coordinates == b);             // −3 < 0
    CHECK(blocks.particle_blocks[0].slot(2) == 10);
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
}

TEST_CASE("particles that leave their blocks are moved with all that is known of them, and the rest stays", "[transfer]") {
    Heap<Weights::quadratic> heap(200);
    Particles<double>& ps = heap.ps;
    struct Known { Vec3d x, v; Mat3d Fe, C; double Jp, m, V0, stress; };
    const auto known = [&] {
        std::vector<Known> all(200);
        heap.grid.blocks.for_each_particle([&](std::size_t s) {
            all[ps.id[s]] = {vector_of(ps.x, s), vector_of(ps.v, s), matrix_of(ps.Fe, s), matrix_of(ps.C, s), ps.Jp.at(s),
                             ps.m.at(s), ps.V0.at(s), ps.tau.at(s, 5)};
        });
        return all;
    };
    const std::vector<Known> before = known();
    RandomInput random;
    for (int round = 0; round < 20; ++round) {
        Blocks& blocks = heap.grid.blocks;
        std::vector<std::vector<Departure<double>>> departures(blocks.particle_blocks.size());
        for (std::size_t b = 0; b < departures.size(); ++b)
            for (std::uint32_t n = blocks.particle_blocks[b].count; n-- > 0;) {
                if (random.number() < 0.3) continue;
                const Vec3i to(int(random.bits() % 3), int(random.bits() % 3), round % 5);
                if (to == blocks.particle_blocks[b].coordinates) continue;
                departures[b].push_back({to, node_bit(1, 2, 3), take_out(ps, blocks.particle_blocks[b], n)});
            }
        migrate(ps, blocks, departures, 3);
        std::size_t count = 0;
        for (const ParticleBlock& b : blocks.particle_blocks) {
            count += b.count;
            REQUIRE(b.groups.size() == (b.count + lanes - 1) / lanes);
            for (std::uint32_t n = 0; n < b.count; ++n) REQUIRE(ps.m.at(b.slot(n)) > 0);
        }
        REQUIRE(count == 200);
        const std::vector<Known> after = known();
        for (std::size_t p = 0; p < 200; ++p) {
            const Known &a = before[p], &c = after[p];
            REQUIRE((a.x == c.x && a.v == c.v && a.Fe == c.Fe && a.C == c.C));
            REQUIRE((a.Jp == c.Jp && a.m == c.m && a.V0 == c.V0 && a.stress == c.stress));
        }
    }
}

TEST_CASE("a block is found by its coordinates", "[transfer]") {
    BlockMap map(1);
    for (int i = 0; i < 5000; ++i) REQUIRE(map.number_of(Vec3i(i, -i, 3 * i)) == std::uint32_t(i));
    for (int i = 0; i < 5000; ++i) REQUIRE(map.number_of(Vec3i(i, -i, 3 * i)) == std::uint32_t(i));
}
