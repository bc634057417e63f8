#include "base/diffusion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stylet {
namespace {

float times(float a, float w) {
    return a * w;
}
DiffusionNode times(const DiffusionNode& a, float w) {
    return {a.lanes * w};
}
void add(float& sum, float a) {
    sum += a;
}
void add(DiffusionNode& sum, const DiffusionNode& a) {
    sum.lanes += a.lanes;
}

}  // namespace

Diffusion::Level::Level(int side) : nodes(side) {
    const std::size_t count = std::size_t(side) * std::size_t(side) * std::size_t(side);
    stiffness.assign(count, 1.0f);
    pull.assign(count, 0.0f);
    to_x.assign(count, 1.0f), to_y = to_x, to_z = to_x;
    inverse.assign(count, 1.0f / 6.0f);
    u.resize(count), source.resize(count), residual.resize(count);
}

Diffusion::Diffusion(int nodes) {
    assert(nodes >= 5 && ((nodes - 1) & (nodes - 2)) == 0 && "2^k + 1 nodes a side");
    for (int side = nodes; side >= 3; side = (side - 1) / 2 + 1)
        levels_.emplace_back(side);
}

void Diffusion::resetPull(const std::vector<float>& base_pull) noexcept {
    Level& finest = levels_.front();
    finest.pull = base_pull;
    std::fill(finest.source.begin(), finest.source.end(), DiffusionNode{});
}

void Diffusion::addPull(std::size_t at, float pull, const glm::vec3& target) noexcept {
    Level& finest = levels_.front();
    finest.pull[at] += pull;
    finest.source[at].lanes += pull * Lanes{target.x, target.y, target.z, 0.0f};
}

glm::vec3 Diffusion::at(std::size_t node) const noexcept {
    const Lanes& u = levels_.front().u[node].lanes;
    return {u[0], u[1], u[2]};
}

void Diffusion::clear() noexcept {
    std::fill(levels_.front().u.begin(), levels_.front().u.end(), DiffusionNode{});
}

// The conductance of a link is that of its two nodes in series. So a rigid node acts up to half way to its
// soft neighbour, and a node without stiffness insulates.
void Diffusion::link(Level& level) noexcept {
    const std::size_t n = std::size_t(level.nodes), last = level.stiffness.size();
    const auto series = [&](std::size_t a, std::size_t b) {
        const float p = level.stiffness[a], q = level.stiffness[b];
        return 2.0f * p * q / (p + q);
    };
    // At the end of a row the next index is in the next row. Such links lead to faces and are not used.
    for (std::size_t i = 0; i < last; ++i) {
        level.to_x[i] = series(i, std::min(i + 1, last - 1));
        level.to_y[i] = series(i, std::min(i + n, last - 1));
        level.to_z[i] = series(i, std::min(i + n * n, last - 1));
    }
}

void Diffusion::invertDiagonal(Level& level) noexcept {
    const std::size_t n = std::size_t(level.nodes), slice = n * n;
    for (std::size_t i = slice; i < level.inverse.size(); ++i)
        level.inverse[i] = 1.0f / (level.to_x[i] + level.to_x[i - 1] + level.to_y[i] + level.to_y[i - n] +
                                   level.to_z[i] + level.to_z[i - slice] + level.pull[i]);
}

// Full weighting of the 27 fine nodes around each inner coarse node. Faces are left unchanged.
template <typename Value>
void Diffusion::restrictTo(std::size_t coarse_level, std::vector<Value> Level::* from,
                           std::vector<Value> Level::* to, float scale) noexcept {
    const Level& fine = levels_[coarse_level - 1];
    Level& coarse = levels_[coarse_level];
    const std::ptrdiff_t row = fine.nodes, slice = row * row;
    for (int z = 1; z < coarse.nodes - 1; ++z)
        for (int y = 1; y < coarse.nodes - 1; ++y)
            for (int x = 1; x < coarse.nodes - 1; ++x) {
                const Value* const at = (fine.*from).data() + fine.offset(2 * x, 2 * y, 2 * z);
                Value sum{};
                for (int dz = -1; dz <= 1; ++dz)
                    for (int dy = -1; dy <= 1; ++dy) {
                        const Value* const line = at + dz * slice + dy * row;
                        const float weight = scale / float((2 << std::abs(dz)) * (2 << std::abs(dy)));
                        add(sum, times(line[0], 0.5f * weight));
                        add(sum, times(line[-1], 0.25f * weight));
                        add(sum, times(line[1], 0.25f * weight));
                    }
                (coarse.*to)[coarse.offset(x, y, z)] = sum;
            }
}

void Diffusion::prepareStiffness() noexcept {
    link(levels_.front());
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        restrictTo(level, &Level::stiffness, &Level::stiffness, 1.0f);
        link(levels_[level]);
    }
}

void Diffusion::preparePull() noexcept {
    for (std::size_t level = 0; level < levels_.size(); ++level) {
        // Factor 4: pulls include the squared spacing.
        if (level > 0) restrictTo(level, &Level::pull, &Level::pull, 4.0f);
        invertDiagonal(levels_[level]);
    }
}

void Diffusion::sweep(Level& level, int colour) noexcept {
    const std::size_t n = std::size_t(level.nodes), slice = n * n;
    DiffusionNode* const u = level.u.data();
    for (int z = 1; z < level.nodes - 1; ++z)
        for (int y = 1; y < level.nodes - 1; ++y) {
            const std::size_t row = level.offset(0, y, z);
            for (std::size_t i = row + 1 + std::size_t((y + z + colour) & 1); i < row + n - 1; i += 2)
                u[i].lanes = (level.source[i].lanes + u[i - 1].lanes * level.to_x[i - 1] +
                              u[i + 1].lanes * level.to_x[i] + u[i - n].lanes * level.to_y[i - n] +
                              u[i + n].lanes * level.to_y[i] + u[i - slice].lanes * level.to_z[i - slice] +
                              u[i + slice].lanes * level.to_z[i]) *
                             level.inverse[i];
        }
}

void Diffusion::findResidual(Level& level) noexcept {
    const std::size_t n = std::size_t(level.nodes), slice = n * n;
    const DiffusionNode* const u = level.u.data();
    for (int z = 1; z < level.nodes - 1; ++z)
        for (int y = 1; y < level.nodes - 1; ++y) {
            const std::size_t row = level.offset(0, y, z);
            for (std::size_t i = row + 1; i < row + n - 1; ++i)
                level.residual[i].lanes =
                    level.source[i].lanes + (u[i - 1].lanes - u[i].lanes) * level.to_x[i - 1] +
                    (u[i + 1].lanes - u[i].lanes) * level.to_x[i] +
                    (u[i - n].lanes - u[i].lanes) * level.to_y[i - n] +
                    (u[i + n].lanes - u[i].lanes) * level.to_y[i] +
                    (u[i - slice].lanes - u[i].lanes) * level.to_z[i - slice] +
                    (u[i + slice].lanes - u[i].lanes) * level.to_z[i] - u[i].lanes * level.pull[i];
        }
}

// Adds the coarse level's solution, interpolated linearly between its nodes.
void Diffusion::addCoarseCorrection(std::size_t coarse_level) noexcept {
    const Level& coarse = levels_[coarse_level];
    Level& fine = levels_[coarse_level - 1];
    for (int z = 1; z < fine.nodes - 1; ++z)
        for (int y = 1; y < fine.nodes - 1; ++y) {
            const DiffusionNode* const a = coarse.u.data() + coarse.offset(0, y / 2, z / 2);
            const DiffusionNode* const b = coarse.u.data() + coarse.offset(0, (y + 1) / 2, z / 2);
            const DiffusionNode* const c = coarse.u.data() + coarse.offset(0, y / 2, (z + 1) / 2);
            const DiffusionNode* const d = coarse.u.data() + coarse.offset(0, (y + 1) / 2, (z + 1) / 2);
            DiffusionNode* const row = fine.u.data() + fine.offset(0, y, z);
            Lanes low = 0.25f * (a[0].lanes + b[0].lanes + c[0].lanes + d[0].lanes);
            for (int x = 0; x < coarse.nodes - 1; ++x) {
                const Lanes high =
                    0.25f * (a[x + 1].lanes + b[x + 1].lanes + c[x + 1].lanes + d[x + 1].lanes);
                if (x > 0) row[2 * x].lanes += low;
                row[2 * x + 1].lanes += 0.5f * (low + high);
                low = high;
            }
        }
}

void Diffusion::solve(std::size_t at, int sweeps) noexcept {
    Level& level = levels_[at];
    for (int i = 0; i < sweeps; ++i)
        sweep(level, 0), sweep(level, 1);
    if (at + 1 == levels_.size()) return;  // a single inner node: solved
    findResidual(level);
    Level& coarse = levels_[at + 1];
    restrictTo(at + 1, &Level::residual, &Level::source, 4.0f);
    std::fill(coarse.u.begin(), coarse.u.end(), DiffusionNode{});
    solve(at + 1, sweeps);
    addCoarseCorrection(at + 1);
    for (int i = 0; i < sweeps; ++i)
        sweep(level, 1), sweep(level, 0);
}

void Diffusion::cycle(int sweeps) noexcept {
    solve(0, sweeps);
}

float Diffusion::residual() noexcept {
    Level& level = levels_.front();
    findResidual(level);
    float largest = 0.0f;
    for (std::size_t i = 0; i < level.residual.size(); ++i) {
        const Lanes r = level.residual[i].lanes * level.inverse[i];
        largest = std::max(largest, std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]));
    }
    return largest;
}

float Diffusion::maxDifference() const noexcept {
    const Level& level = levels_.front();
    const std::size_t n = std::size_t(level.nodes), slice = n * n;
    const DiffusionNode* const u = level.u.data();
    float largest = 0.0f;
    for (std::size_t i = 0; i + slice + n + 1 < level.u.size(); ++i) {
        const Lanes x = u[i + 1].lanes - u[i].lanes, y = u[i + n].lanes - u[i].lanes,
                    z = u[i + slice].lanes - u[i].lanes;
        const Lanes sum = x * x + y * y + z * z;
        largest = std::max(largest, sum[0] + sum[1] + sum[2]);
    }
    return std::sqrt(largest);
}

}  // namespace stylet
