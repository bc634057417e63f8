// A look: which tissue is how opaque and in what colour. Data (assets/looks/*.toml), resolved against one
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

namespace stylet::render {

struct HuPoint {
    double hu = 0.0;
    double extinction_per_m = 0.0;
    glm::vec3 colour_linear{0.0f};
};

// Applies to the labels whose tissue and name fit; the first rule that fits wins.
struct LookRule {
    std::optional<patient::Tissue> tissue;
    std::string name;                        // part of the label's name, lower case; empty = any
    std::optional<double> extinction_per_m;  // absent: the curve over HU
    std::optional<double> shell_per_m;  // extinction where it borders on something clearer; absent: the same
    std::optional<glm::vec3> colour_linear;  // absent: the colour of the package's label table
};

struct LookStyle {
    std::string name;
    std::vector<HuPoint> hu;  // ascending; constant beyond its ends; linear between in the stored form
    std::vector<LookRule> rules;
    double full_extinction_per_m = 1.0;  // the largest of all: a stored opacity of 1
    float wrap = 0.3f, specular = 0.1f, specular_power = 24.0f, rim = 0.0f;
    float gradient_voxels = 1.0f;  // reach of the central differences
    int smoothing_voxels = 1;      // radius of the binomial filter over the classified volume
    // The smoothed opacity between these is stretched to 0..1, or smoothing would carry surfaces outwards.
    float edge_low = 0.0f, edge_high = 1.0f;
    glm::vec3 grazing_tint{1.0f};
    float mottle = 0.0f, pores = 0.0f;  // of the skin close by, 0..1
};

LookStyle loadLook(const std::filesystem::path& toml);  // throws patient::DataError
// The same from memory; `file` is named in what is thrown.
LookStyle parseLook(const std::filesystem::path& file, std::string_view toml);

// Stored form of a colour with an extinction: rgb = sqrt(linear colour) * a, a = sqrt(extinction / full). The
// roots spend the eight bits where the eye sees them, and the weight keeps clear tissue from bleeding its
// colour.
struct Palette {
    static constexpr int kHuBegin = -1024, kHuEnd = 3072;
    std::array<glm::vec4, 256> label{};
    std::array<bool, 256> follows_hu{};  // opacity from the curve, colour from `label`.rgb (sqrt, weight 1)
    int smoothing_voxels = 1;
    float edge_low = 0.0f, edge_high = 1.0f;
    std::vector<glm::vec4> hu;  // kHuEnd - kHuBegin entries
    std::array<std::optional<glm::vec4>, 256> shell{};
    glm::vec4 at(std::int16_t ct_hu, std::uint8_t id) const;
    // Whether a voxel of `id` shows its shell beside one of `neighbour`.
    bool borders(std::uint8_t id, std::uint8_t neighbour) const {
        return follows_hu[neighbour] || label[neighbour].a < label[id].a;
    }
};
Palette resolve(const LookStyle&, const patient::Patient&);

}  // namespace stylet::render
