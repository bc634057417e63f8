// Builds a patient from its CT alone and measures Dice and time. Varies the voxel size of all stages, the
// grid, the affine share and the iterations of the atlas registration, and the spacing of the liver's first
// cut. The patient has one of the seeds that the stages were tuned on, so these rows serve to choose
// defaults. They do not evaluate the accuracy.
#include <algorithm>

#include <fmt/core.h>

#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/segmentation/build.h"
#include "app/modeller/segmentation/judgement.h"
#include "app/modeller/segmentation/liver.h"
#include "patient/package/nifti.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
#include "tests/support/temp_folder.h"

namespace stylet::bench {
namespace {

using modeller::Mask;
using patient::Package;

constexpr std::uint64_t kSeed = 5;
constexpr double kCt_m = 0.001;

// A stage and the structure that evaluates it.
struct Stage {
    const char* name;
    const char* structure;
};
constexpr Stage kStages[] = {{"lungs", "right lung"},   {"bones", "bone"},
                             {"liver", "liver, whole"}, {"vessels", "vessels in the liver"},
                             {"ducts", "bile ducts"},   {"organs", "right kidney"},
                             {"fascia", "fascia"},      {"skin", "skin"}};

void addVoxelRows(std::vector<Row>& rows, const modeller::BuildResult& built, const Package& truth,
                  double spacing_m) {
    const std::vector<modeller::StructureAgreement> judged =
        modeller::compareStructures(truth, built.package, {});
    for (const Stage& stage : kStages)
        for (const modeller::StageReport& report : built.stages)
            for (const auto& [structure, a] : judged)
                if (report.name == stage.name && structure == stage.structure) {
                    const std::string note =
                        fmt::format("{}; mean surface {:.2f} mm", stage.structure, 1e3 * a.mean_surface_m);
                    rows.push_back({"model." + report.name, "voxel [mm]", 1e3 * spacing_m,
                                    1e3 * report.seconds, 1.0 - a.dice, "1 - Dice",
                                    "the labels of a reference patient", note});
                }
}

// Adds rows for the liver's own settings. Everything else comes from `found`.
void addLiverRows(std::vector<Row>& rows, const Package& truth, const Package& found) {
    const auto labelled = [&](std::initializer_list<std::string_view> names) {
        return modeller::labelMask(found.labels, [&](const patient::Label& l) {
            return std::find(names.begin(), names.end(), l.name) != names.end();
        });
    };
    const Mask lungs = labelled({"right lung", "left lung"});
    const Mask bones = labelled({"right ribs", "left ribs", "spine", "sternum", "bone"});
    Mask body(found.ct.grid);
    for (std::size_t i = 0; i < body.voxels.size(); ++i)
        body.voxels[i] = found.ct.voxels[i] != modeller::kOutside_hu;
    Package judged = found;
    const auto row = [&](const char* knob, double value, modeller::AtlasSettings atlas,
                         const modeller::LiverSettings& settings) {
        std::vector<modeller::AtlasImage> images;
        for (const std::uint64_t seed : modeller::kAtlasSeeds)
            images.emplace_back(referencePatient(0.0025, seed), atlas);
        const auto start = std::chrono::steady_clock::now();
        const modeller::AtlasPrior prior = modeller::alignAtlases(found.ct, body, lungs, images, atlas);
        const modeller::Liver liver = modeller::findLiver(found.ct, body, lungs, bones, prior, settings);
        const double time_ms = elapsed_ms(start);
        for (std::uint8_t& id : judged.labels.voxels)
            id = 0;
        modeller::paint(judged.labels, liver.mask, modeller::findTarget("liver")->id, true);
        for (const auto& [structure, a] : modeller::compareStructures(truth, judged, {}))
            if (structure == "liver, whole") {
                const std::string note = fmt::format("mean surface {:.2f} mm", 1e3 * a.mean_surface_m);
                rows.push_back({"model.liver", knob, value, time_ms, 1.0 - a.dice, "1 - Dice",
                                "the labels of a reference patient", note});
            }
    };
    for (const int iterations : {0, 10, 20, 40, 80}) {
        modeller::AtlasSettings atlas;
        atlas.iterations = iterations;
        row("atlas iterations", iterations, atlas, {});
    }
    for (const double grid_mm : {8.0, 6.0, 4.0, 3.0}) {
        if (grid_mm < 4.0 && !isLongRun()) continue;
        modeller::AtlasSettings atlas;
        atlas.spacing_m = 1e-3 * grid_mm;
        row("atlas grid [mm]", grid_mm, atlas, {});
    }
    for (const double share : {1.0, 0.5, 0.25, 0.1}) {
        modeller::AtlasSettings atlas;
        atlas.affine_share = share;
        row("atlas affine share", share, atlas, {});
    }
    for (const double coarse_mm : {6.0, 4.0, 3.0, 2.0}) {
        modeller::LiverSettings settings;
        settings.coarse_m = 1e-3 * coarse_mm;
        row("first cut [mm]", coarse_mm, {}, settings);
    }
}

void run(std::vector<Row>& rows) {
    const test::TempFolder folder;
    const Package truth = referencePatient(kCt_m, kSeed);
    patient::writeNifti(folder / "ct.nii.gz", truth.ct);
    for (const double spacing_mm : {3.0, 2.0, 1.5, 1.0}) {
        modeller::BuildSettings settings;
        settings.ct = folder / "ct.nii.gz";
        settings.stages = folder / "stages";
        settings.spacing_m = 1e-3 * spacing_mm;
        settings.reference_phase = "exhale";
        settings.defaults = test::tissueDefaults();
        const modeller::BuildResult built = modeller::build(settings);
        addVoxelRows(rows, built, truth, settings.spacing_m);
        if (spacing_mm == 2.0) addLiverRows(rows, truth, built.package);
    }
}

const Registration registration("model", run);

}  // namespace
}  // namespace stylet::bench
