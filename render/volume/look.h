// A look: opacity and colour of each tissue. Loaded from assets/looks/*.toml and resolved against one
// patient's label table into a palette per label and a curve over HU.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "patient/patient.h"
#include "render/scene/label_rule.h"

namespace stylet::render {

struct HuPoint {
    double hu = 0.0;
    double extinction_per_m = 0.0;
    glm::vec3 colour_linear{0.0f};
};

struct LookRule : LabelRule {
    std::optional<double> extinction_per_m;  // absent: the curve over HU
    std::optional<double> shell_per_m;       // extinction at borders to clearer tissue; absent: no shell
    std::optional<glm::vec3> colour_linear;  // absent: the colour of the package's label table
};

struct LookStyle {
    std::string name;
    std::vector<HuPoint> hu;  // ascending; linear between points in the stored form, constant beyond the ends
    std::vector<LookRule> rules;
    double full_extinction_per_m = 1.0;  // largest extinction; stored as opacity 1
    float wrap = 0.3f, specular = 0.1f, specular_power = 24.0f, rim = 0.0f;
    float gradient_voxels = 1.0f;  // reach of the central differences
    int smoothing_voxels = 1;      // radius of the binomial filter over the classified volume
    // Smoothed opacities from edge_low to edge_high are stretched to 0..1. Otherwise smoothing would move
    // surfaces outwards.
    float edge_low = 0.0f, edge_high = 1.0f;
    glm::vec3 grazing_tint{1.0f};
    float mottle = 0.0f, pores = 0.0f;  // detail of the skin from close by, 0..1
};

LookStyle loadLook(const std::filesystem::path& toml);  // throws DataError
// The same from memory; errors name `file`.
LookStyle parseLook(const std::filesystem::path& file, std::string_view toml);

// Stored form of a colour with an extinction: rgb = sqrt(linear colour) * a, a = sqrt(extinction / full). The
// square roots spend the eight bits where the eye is sensitive. The weight `a` prevents the colour of clear
// tissue from bleeding into its neighbours.
struct Palette {
    static constexpr int kHuBegin = -1024, kHuEnd = 3072;
    std::array<glm::vec4, 256> label{};
    std::array<bool, 256> follows_hu{};  // opacity from the curve, colour from `label`.rgb (sqrt, weight 1)
    int smoothing_voxels = 1;
    float edge_low = 0.0f, edge_high = 1.0f;
    std::vector<glm::vec4> hu;  // kHuEnd - kHuBegin entries
    std::array<std::optional<glm::vec4>, 256> shell{};
    glm::vec4 at(std::int16_t ct_hu, std::uint8_t id) const;
    // True if a voxel of `id` shows its shell next to one of `neighbour`.
    bool borders(std::uint8_t id, std::uint8_t neighbour) const {
        return follows_hu[neighbour] || label[neighbour].a < label[id].a;
    }
};
Palette makePalette(const LookStyle&, const patient::Patient&);

}  // namespace stylet::render
