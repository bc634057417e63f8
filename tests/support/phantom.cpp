#include "tests/support/phantom.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace stylet::test {

using patient::Label;
using patient::Tissue;

const patient::TissueDefaults& tissueDefaults() {
    static const patient::TissueDefaults defaults = [] {
        const char* assets = std::getenv("STYLET_ASSETS");
        if (!assets) throw std::runtime_error("STYLET_ASSETS is not set: run through ctest");
        return patient::loadTissueDefaults(std::filesystem::path(assets) / "tissue" / "ptcd.toml");
    }();
    return defaults;
}

const std::vector<Label>& tissueLabels() {
    static const std::vector<Label> labels = [] {
        std::vector<Label> list;
        for (int t = 1; t < patient::kTissueCount; ++t) {
            Label label;
            label.id = std::uint8_t(t);
            label.name = patient::tissueName(Tissue(t));
            label.tissue = Tissue(t);
            label.role = tissueDefaults().tissues[std::size_t(t)].role;
            label.abdominal =
                Tissue(t) == Tissue::liver || Tissue(t) == Tissue::vessel || Tissue(t) == Tissue::duct;
            if (Tissue(t) == Tissue::cartilage) label.structure = patient::Structure::cartilage;
            if (Tissue(t) == Tissue::vessel) label.blood = patient::BloodKind::other;
            label.colour = {std::uint8_t(30 * t), std::uint8_t(255 - 30 * t), 128};
            label.provenance = "phantom";
            list.push_back(label);
        }
        return list;
    }();
    return labels;
}

namespace {

std::int16_t ctValue(Tissue t) {
    constexpr std::int16_t kHu[patient::kTissueCount] = {-1000, -350, 40, 700, 60, 110, 170, 10, 105};
    return kHu[std::size_t(t)];
}

int voxelsIn(double length_m, double spacing_m) {
    const double count = length_m / spacing_m;
    assert(std::abs(count - std::round(count)) < 1e-6 && "a layer is a whole number of voxels");
    return int(std::round(count));
}

}  // namespace

patient::Package makeSlabs(const std::vector<std::pair<Tissue, double>>& layers_m, double spacing_m,
                           bool labelled) {
    std::vector<Tissue> columns(std::size_t(std::ceil(kSlabAirMargin_m / spacing_m)), Tissue::air);
    const int margin = int(columns.size());
    for (const auto& [tissue, thickness_m] : layers_m)
        columns.insert(columns.end(), std::size_t(voxelsIn(thickness_m, spacing_m)), tissue);

    const double across_m = std::max(spacing_m, 0.001);
    const int across = 2 * int(std::round(kSlabHalfWidth_m / across_m)) + 1;
    Grid grid;
    grid.dims = {int(columns.size()), across, across};
    grid.spacing_m = {spacing_m, across_m, across_m};
    grid.origin_m = {(0.5 - margin) * spacing_m, -(across / 2) * across_m, -(across / 2) * across_m};

    patient::Package package;
    package.name = "slabs";
    package.licence = "CC0-1.0";
    package.provenance = "tests/support/phantom.cpp";
    package.tissues = tissueDefaults().tissues;
    package.elasticity = tissueDefaults().elasticity;
    package.thresholds = tissueDefaults().thresholds;
    package.ct = CtVolume(grid);
    package.labels = LabelVolume(grid);
    if (labelled) package.label_table = tissueLabels();
    for (std::size_t i = 0; i < package.ct.voxels.size(); ++i) {
        const Tissue tissue = columns[i % columns.size()];
        package.ct.voxels[i] = ctValue(tissue);
        package.labels.voxels[i] = labelled ? std::uint8_t(tissue) : std::uint8_t(0);
    }
    return package;
}

}  // namespace stylet::test
