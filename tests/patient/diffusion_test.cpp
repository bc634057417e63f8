#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "base/diffusion.h"

namespace stylet::patient {
namespace {

constexpr int kNodes = 17;

template <typename Visit>
void forEachInner(const Diffusion& d, const Visit& visit) {
    for (int z = 1; z < d.nodes() - 1; ++z)
        for (int y = 1; y < d.nodes() - 1; ++y)
            for (int x = 1; x < d.nodes() - 1; ++x)
                visit(x, y, z, d.offset(x, y, z));
}

// First eigenmode of a cube. The discrete Laplacian only scales it.
float mode(int x, int y, int z) {
    const auto s = [](int i) { return std::sin(std::numbers::pi * i / (kNodes - 1)); };
    return float(s(x) * s(y) * s(z));
}

TEST(Diffusion, EigenmodeIsScaledByTheAnalyticFactor) {
    Diffusion d(kNodes);
    constexpr float kPull = 0.05f;
    d.prepareStiffness();
    d.resetPull(std::vector<float>(d.stiffness().size(), 0.0f));
    forEachInner(d, [&](int x, int y, int z, std::size_t at) {
        d.addPull(at, kPull, mode(x, y, z) * glm::vec3(1.0f, -2.0f, 0.5f));
    });
    d.preparePull();
    for (int i = 0; i < 12; ++i)
        d.cycle(1);
    const double sine = std::sin(0.5 * std::numbers::pi / (kNodes - 1)), eigenvalue = 12.0 * sine * sine;
    const float scale = float(double(kPull) / (double(kPull) + eigenvalue));
    forEachInner(d, [&](int x, int y, int z, std::size_t at) {
        const glm::vec3 expected = scale * mode(x, y, z) * glm::vec3(1.0f, -2.0f, 0.5f);
        EXPECT_LT(glm::length(d.at(at) - expected), 2e-5f) << x << ' ' << y << ' ' << z;
    });
}

// Layers in series between a fixed plane and the cube's face. The displacement falls in each layer in
// proportion to its compliance.
TEST(Diffusion, DisplacementFallsMostInSoftLayers) {
    Diffusion d(kNodes);
    const int middle = kNodes / 2;
    forEachInner(d, [&](int x, int, int, std::size_t at) { d.stiffness()[at] = x < 4 ? 4.0f : 1.0f; });
    d.prepareStiffness();
    d.resetPull(std::vector<float>(d.stiffness().size(), 0.0f));
    forEachInner(d, [&](int x, int, int, std::size_t at) {
        if (x >= middle) d.addPull(at, 1e4f, glm::vec3(1.0f));
    });
    d.preparePull();
    for (int i = 0; i < 30; ++i)
        d.cycle(2);
    EXPECT_LT(d.residual(), 1e-5f);
    const auto u = [&](int x) { return d.at(d.offset(x, middle, middle)).x; };
    EXPECT_NEAR(u(middle), 1.0f, 1e-3f);
    EXPECT_GT((u(6) - u(5)) / (u(2) - u(1)), 3.0f);
    for (int x = 1; x < middle; ++x)
        EXPECT_GT(u(x + 1), u(x)) << x;
}

TEST(Diffusion, CyclesConvergeToSinglePrecision) {
    Diffusion d(33);
    // A half space with bone in it, surrounded by air.
    std::vector<float> base_pull(d.stiffness().size(), 0.0f);
    forEachInner(d, [&](int x, int y, int z, std::size_t at) {
        d.stiffness()[at] = x < 16 ? 1e-3f : 1.0f;
        if (x > 20 && x < 23 && y < 18 && z > 8) d.stiffness()[at] = base_pull[at] = 1e5f;
    });
    d.prepareStiffness();
    d.resetPull(base_pull);
    for (int z = 15; z <= 17; ++z)
        for (int y = 15; y <= 17; ++y)
            d.addPull(d.offset(16, y, z), 10.0f, glm::vec3(1.0f));
    d.preparePull();
    d.cycle(2);
    float last = d.residual();
    for (int i = 0; i < 8; ++i) {
        d.cycle(2);
        EXPECT_LT(d.residual(), 0.75f * last);
        last = d.residual();
    }
    for (int i = 0; i < 40; ++i)
        d.cycle(2);
    EXPECT_LT(d.residual(), 1e-6f);
}

}  // namespace
}  // namespace stylet::patient
