#pragma once
#include "sim/elements.h"

#include <Eigen/Cholesky>

#include <numeric>

namespace firn {

/// Sets that are joined two at a time; each is named by its least member.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// The pieces of implicit snow that no stencil joins, and what moves each as a whole. Internal forces give a piece neither
/// momentum nor angular momentum, but a solve that ends early would, of its tolerance's size. (M + β Δt² H) maps a
/// translation c, and under Hooke's law a rotation ω × (x − x̄), to M times itself. So the motion of each piece as a rigid
/// body that makes Σ r_i and Σ (x_i − x̄) × r_i of its residual r vanish is known exactly, whatever else the solve did.
template <class Real, Weights kind> class Pieces {
public:
    Pieces(const Elements<Real, kind>& elements, const Grid<Real>& grid, const Pages<Real>& m, bool rotations)
        : m_(m), rotations_(rotations), piece_(elements.nodes()), x_(elements.nodes()) {
        DisjointSets sets(elements.nodes());
        for (const auto& b : elements.blocks()) join(elements, b, sets);
        std::vector<std::uint32_t> number(elements.nodes());
        for (std::uint32_t i = 0; i < piece_.size(); ++i) {
            const std::uint32_t root = sets.find(i);
            if (root == i) number[i] = static_cast<std::uint32_t>(pieces_.size()), pieces_.push_back({});
            piece_[i] = number[root];
        }
        find_positions(elements, grid);
        for (std::size_t i = 0; i < piece_.size(); ++i) pieces_[piece_[i]].mass += m[i], pieces_[piece_[i]].center += double(m[i]) * x_[i].template cast<double>();
        for (Piece& p : pieces_) p.center /= p.mass;
        for (std::size_t i = 0; i < piece_.size(); ++i) {
            Piece& p = pieces_[piece_[i]];
            const Vec3d r = x_[i].template cast<double>() - p.center;
            p.inertia += double(m[i]) * (r.squaredNorm() * Mat3d::Identity() - r * r.transpose());
        }
    }

    /// `fixed`: nodes, by their new numbers, that contact holds; along an axis that it holds anywhere a piece is not moved.
    /// One with a node of `attached` is not moved at all.
    void hold(const std::vector<FixedNode<Real>>& fixed, const std::vector<std::size_t>& attached) {
        for (Piece& p : pieces_) p.moves = {1, 1, 1}, p.turns = rotations_;
        for (const FixedNode<Real>& f : fixed) {
            Piece& p = pieces_[piece_[f.node]];
            p.turns = false;
            for (int a = 0; a < 3; ++a) p.moves(a) = f.free(a, a) == 1 ? p.moves(a) : 0;
        }
        for (const std::size_t i : attached) pieces_[piece_[i]].moves.setZero(), pieces_[piece_[i]].turns = false;
    }

    std::size_t size() const { return pieces_.size(); }

    /// Moves each piece: adds to u, takes M times it from the residual r; both by node.
    void balance(NodeField<Real>& u, NodeField<Real>& r) {
        for (Piece& p : pieces_) p.force.setZero(), p.torque.setZero();
        for (std::size_t i = 0; i < piece_.size(); ++i) {
            Piece& p = pieces_[piece_[i]];
            const Vec3d f(r.at[i][0], r.at[i][1], r.at[i][2]);
            p.force += f, p.torque += (x_[i].template cast<double>() - p.center).cross(f);
        }
        for (Piece& p : pieces_) {
            p.velocity = p.moves.cwiseProduct(p.force) / p.mass;
            p.spin = p.turns ? Vec3d(p.inertia.ldlt().solve(p.torque)) : Vec3d::Zero();
        }
        u.for_each([&](std::ptrdiff_t i) {
            const Piece& p = pieces_[piece_[i]];
            const Vec3d v = p.velocity + p.spin.cross(x_[i].template cast<double>() - p.center);
            const auto moved = NodeVector<Real>::of(v(0), v(1), v(2), 0);
            u.at[i] += moved, r.at[i] -= NodeVector<Real>(m_[i]) * moved;
        });
    }

private:
    struct Piece {
        double mass = 0;
        Vec3d center{0, 0, 0}, moves{1, 1, 1}, force{0, 0, 0}, torque{0, 0, 0}, velocity{0, 0, 0}, spin{0, 0, 0};
        Mat3d inertia = Mat3d::Zero();
        bool turns = true;
    };

    static void join(const Elements<Real, kind>& elements, const typename Elements<Real, kind>::StiffBlock& b, DisjointSets& sets) {
        for (const NodeSet part : b.parts) {
            const auto rows = elements.reached(part);
            std::uint32_t first = no_slot;
            for (const Link& l : b.links) {
                if (!elements.is_in(rows, l.at)) continue;
                if (first == no_slot) first = l.node;
                else sets.join(first, l.node);
            }
        }
    }
    void find_positions(const Elements<Real, kind>& elements, const Grid<Real>& grid) {
        const auto count = static_cast<std::ptrdiff_t>(grid.blocks.grid_blocks.size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t n = 0; n < count; ++n) {
            const GridBlock& b = grid.blocks.grid_blocks[n];
            std::uint32_t i = b.first;
            for (NodeSet left = b.nodes; left != 0; left &= left - 1, ++i)
                if (const std::uint32_t to = elements.number_of(i); to != no_slot) x_[to] = grid.position(b, std::countr_zero(left)).template cast<Real>();
        }
    }

    const Pages<Real>& m_;
    bool rotations_;
    std::vector<std::uint32_t> piece_;      ///< of each node.
    std::vector<Vec3<Real>> x_;             ///< of each node [m].
    std::vector<Piece> pieces_;
};

}  // namespace firn
