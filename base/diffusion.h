// Spreads a displacement that is known at some places through tissue of varying stiffness. Solves this
// equation on a small cube of nodes:
//   div(stiffness grad u) = pull (u - target),   u = 0 on the cube's faces
// Solved by multigrid: V-cycles of red-black Gauss-Seidel; each level discretises the equation itself
// (Briggs, Henson and McCormick, "A Multigrid Tutorial", 2000). For pictures only: single precision, never
// hashed.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace stylet {

// Three components and one unused, in one SIMD register.
using Lanes = float __attribute__((vector_size(16)));
struct DiffusionNode {
    Lanes lanes{};
};

class Diffusion {
  public:
    // `nodes` per side: 2^k + 1, k >= 2.
    explicit Diffusion(int nodes);

    int nodes() const noexcept { return levels_.front().nodes; }
    std::size_t offset(int x, int y, int z) const noexcept { return levels_.front().offset(x, y, z); }

    // Stiffness of the finest nodes, x-fastest. Call prepareStiffness() after changing it.
    std::vector<float>& stiffness() noexcept { return levels_.front().stiffness; }
    void prepareStiffness() noexcept;

    // Sets the pull of every node: resetPull() gives every node a pull toward zero of strength `base_pull`;
    // addPull() then adds pulls toward a target. Pulls are multiplied by the squared spacing. Call
    // preparePull() afterwards, and also after a change of stiffness.
    void resetPull(const std::vector<float>& base_pull) noexcept;
    void addPull(std::size_t at, float pull, const glm::vec3& target) noexcept;
    void preparePull() noexcept;

    void clear() noexcept;  // u = 0
    void cycle(int sweeps) noexcept;
    // Largest change of u if one node's equation were solved now.
    float residual() noexcept;
    // Largest change of u between neighbouring nodes.
    float maxDifference() const noexcept;
    glm::vec3 at(std::size_t node) const noexcept;
    const std::vector<DiffusionNode>& solution() const noexcept { return levels_.front().u; }

  private:
    struct Level {
        int nodes = 0;
        std::vector<float> stiffness, pull;
        std::vector<float> to_x, to_y, to_z;  // conductance to the next node along each axis
        std::vector<float> inverse;           // inverse diagonal of the system matrix
        std::vector<DiffusionNode> u, source, residual;

        explicit Level(int side);
        std::size_t offset(int x, int y, int z) const noexcept {
            const auto n = std::size_t(nodes);
            return (std::size_t(z) * n + std::size_t(y)) * n + std::size_t(x);
        }
    };
    static void link(Level&) noexcept;
    static void invertDiagonal(Level&) noexcept;
    static void sweep(Level&, int colour) noexcept;
    static void findResidual(Level&) noexcept;
    void solve(std::size_t level, int sweeps) noexcept;
    template <typename Value>
    void restrictTo(std::size_t coarse, std::vector<Value> Level::* from, std::vector<Value> Level::* to,
                    float scale) noexcept;
    void addCoarseCorrection(std::size_t coarse) noexcept;

    std::vector<Level> levels_;
};

}  // namespace stylet
