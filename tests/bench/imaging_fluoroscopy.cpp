// Benchmark of fluoroscopy. Reports the cost of each setting and the error of its line integrals at a
// lattice of pixels. The reference for a still patient is a voxel-exact sum through the CT. The reference
// for a breathing patient samples the motion itself every 0.3 mm. The defaults are the cheapest settings
// whose error is within kBound.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/core.h>

#include "base/parallel.h"
#include "patient/contrast/contrast.h"
#include "patient/displacement/tool_displacement.h"
#include "tests/bench/bench.h"
#include "tests/bench/gpu.h"
#include "tests/bench/reference_patient.h"
#include "tests/render/fluoroscopy/ray_reference.h"
#include "tests/render/pictures.h"

namespace stylet::bench {
namespace {

using render::FluoroscopySettings;

constexpr double kBound = 1e-4;  // 1 - ZNCC
constexpr int kStride = 5;       // every 5th row and column of pixels is compared
constexpr double kFineStep_m = 0.0003;
constexpr double kDeepBreath_v = 0.9;

struct Stage {
    patient::Package package;
    patient::Patient patient{package};
    render::Gpu gpu{{}};
    render::DeformedPatient deformed{gpu, patient};
    render::FluoroscopyInput input;
    patient::Surrogate breath;
    const patient::DisplacementTable* tool = nullptr;
    std::vector<Row>& rows;

    Stage(patient::Package p, std::vector<Row>& to) : package(std::move(p)), rows(to) {
        const Grid& grid = package.ct.grid;
        input.pedal = true;
        input.patient_from_isocentre.position_m =
            grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1) + Vec3(0.03, 0.0, 0.02);
        breathe(0.0);
    }
    void breathe(double v) {
        breath = package.motion.reference;
        breath.v += v;
        deformed.breathe(breath, v == 0.0);
    }
    bool still() const { return deformed.still(); }
    std::string reference() const { return still() ? "voxel-exact sums" : "sums of 0.3 mm steps"; }

    std::vector<double> exactPaths(int pixels) {
        std::vector<test::XrayLine> lines;
        for (int row = kStride / 2; row < pixels; row += kStride)
            for (int column = kStride / 2; column < pixels; column += kStride)
                lines.push_back(test::xrayLine(input, column, row, pixels, FluoroscopySettings{}.detector_m));
        std::vector<double> paths(lines.size());
        parallelFor(2, lines.size(), [&](std::size_t i) {
            paths[i] = still() ? test::exactPath(package.ct, lines[i])
                               : test::finePath({.package = &package,
                                                 .breath = breath,
                                                 .tool = tool,
                                                 .contrast = input.contrast,
                                                 .step_m = kFineStep_m},
                                                lines[i]);
        });
        return paths;
    }

    // Adds a row for these settings: the median time of five pictures after one warm-up picture, and the
    // error against `exact`.
    void add(const std::string& knob, double value, FluoroscopySettings settings,
             const std::vector<double>& exact, const std::string& note) {
        settings.beyond_ends_m = 0.0;
        render::Fluoroscopy fluoroscopy(gpu, deformed);
        fluoroscopy.image(input, settings);
        const double time_ms = medianTime_ms(5, [&] {
            input.time_s += 1.0;
            fluoroscopy.image(input, settings);
        });
        std::vector<double> paths;
        for (int row = kStride / 2; row < settings.pixels; row += kStride)
            for (int column = kStride / 2; column < settings.pixels; column += kStride)
                paths.push_back(double(fluoroscopy.paths()[std::size_t(row * settings.pixels + column)]));
        const double error = 1.0 - test::zncc(exact, paths);
        const std::string decibels =
            fmt::format(", {:.1f} dB{}", test::pathPsnr(exact, paths), error > kBound ? ", too coarse" : "");
        rows.push_back(
            {"imaging.fluoroscopy", knob, value, time_ms, error, "1 - ZNCC", reference(), note + decibels});
    }
};

std::string mark(const std::string& note, bool is_default) {
    return is_default ? note + ", default" : note;
}

// Draws the same picture with and without skipping the collimated rays, and counts the bytes that differ.
void collimationRows(Stage& stage) {
    render::Fluoroscopy fluoroscopy(stage.gpu, stage.deformed);
    std::vector<std::uint8_t> first;
    for (const bool skip : {true, false}) {
        FluoroscopySettings settings;
        settings.skips = {.between_pulses = false, .collimated_rays = skip};
        fluoroscopy.image(stage.input, settings);
        const double time_ms = medianTime_ms(5, [&] { fluoroscopy.image(stage.input, settings); });
        const render::ScreenPicture p = fluoroscopy.picture();
        const std::vector<std::uint8_t> shown(p.rgba, p.rgba + 4 * p.width * p.height);
        if (skip) first = shown;
        double differing = 0.0;
        for (std::size_t i = 0; i < shown.size(); ++i)
            differing += shown[i] != first[i] ? 1.0 : 0.0;
        stage.rows.push_back({"imaging.fluoroscopy", "skip collimated_rays", skip ? 1.0 : 0.0, time_ms,
                              differing, "bytes", "every skip", "blades open to a quarter of the area"});
    }
}

void stillRows(Stage& stage) {
    const FluoroscopySettings usual;
    const std::vector<double> exact = stage.exactPaths(usual.pixels);
    const auto with = [&](auto FluoroscopySettings::* knob, auto value) {
        FluoroscopySettings settings;
        settings.*knob = value;
        return settings;
    };
    for (const double voxel_m : {0.001, 0.0015, 0.002, 0.003})
        stage.add("voxel_mm", 1e3 * voxel_m, with(&FluoroscopySettings::voxel_m, voxel_m), exact,
                  mark("still", voxel_m == usual.voxel_m));
    for (const double step_m : {0.001, 0.002, 0.004})
        stage.add("step_mm", 1e3 * step_m, with(&FluoroscopySettings::step_m, step_m), exact,
                  mark("still", step_m == usual.step_m));
    FluoroscopySettings no_cells;
    no_cells.skips.empty_cells = false;
    stage.add("skip empty_cells", 0.0, no_cells, exact, "still, this one off");
    for (const int pixels : {128, 256, 512}) {
        const std::vector<double> own = stage.exactPaths(pixels);
        stage.add("pixels", pixels, with(&FluoroscopySettings::pixels, pixels), own,
                  mark("still", pixels == usual.pixels));
    }
    stage.input.collimation = {.left_m = 0.075, .right_m = 0.075, .up_m = 0.075, .down_m = 0.075};
    collimationRows(stage);
    stage.input.collimation = {};
}

void breathingRows(Stage& stage) {
    const FluoroscopySettings usual;
    stage.breathe(kDeepBreath_v);
    const std::vector<double> exact = stage.exactPaths(usual.pixels);
    for (const double segment_m : {0.004, 0.008, 0.012, 0.016, 0.024, 0.032}) {
        FluoroscopySettings settings;
        settings.segment_m = segment_m;
        stage.add("stretch_mm", 1e3 * segment_m, settings, exact,
                  mark("breathing", segment_m == usual.segment_m));
    }
    for (const int block : {1, 2, 4}) {
        FluoroscopySettings settings;
        settings.block = block;
        stage.add("block", block, settings, exact, mark("breathing", block == usual.block));
    }
    for (const double step_m : {0.001, 0.002, 0.004}) {
        FluoroscopySettings settings;
        settings.step_m = step_m;
        stage.add("step_mm", 1e3 * step_m, settings, exact, mark("breathing", step_m == usual.step_m));
    }
}

// Returns a contrast table in which every voxel labelled as duct is filled with contrast.
patient::ContrastTable filledDucts(const patient::Package& package) {
    const Grid& ct = package.ct.grid;
    Index3 low = ct.dims, high(0);
    std::array<bool, 256> is_duct{};
    for (const patient::Label& label : package.label_table)
        is_duct[label.id] = label.tissue == patient::Tissue::duct;
    const auto forEachDuct = [&](const auto& visit) {
        forEachVoxel(ct, [&](const Index3& i) {
            if (is_duct[package.labels[i]]) visit(i);
        });
    };
    forEachDuct([&](const Index3& i) { low = glm::min(low, i), high = glm::max(high, i + 1); });
    patient::ContrastTable table{{high - low, ct.spacing_m, ct.centre(low)}, {}, 1};
    table.added_per_m.assign(table.grid.voxelCount(), 0.0f);
    forEachDuct([&](const Index3& i) { table.added_per_m[table.grid.offset(i - low)] = 60.0f; });
    return table;
}

// Rows for further content in a breathing patient: filled ducts, the same with the skip `unchanged_contrast`
// off, and a pressing tool in addition to the filled ducts.
void contentRows(Stage& stage) {
    const FluoroscopySettings usual;
    const auto exact = [&] { return stage.exactPaths(usual.pixels); };
    const patient::ContrastTable ducts = filledDucts(stage.package);
    stage.input.contrast = &ducts;
    const std::vector<double> with_contrast = exact();
    stage.add("contrast", 1.0, usual, with_contrast, "breathing, ducts full");
    FluoroscopySettings rewritten;
    rewritten.skips.unchanged_contrast = false;
    stage.add("skip kept_contrast", 0.0, rewritten, with_contrast, "breathing, ducts full, this one off");
    patient::ToolDisplacement tool(stage.patient);
    const Vec3 at = stage.input.patient_from_isocentre.position_m;
    const patient::ToolContact pressing{.begin_m = at,
                                        .end_m = at + Vec3(0.03, 0.0, 0.0),
                                        .begin_moved_m = {-0.006, 0.0, 0.0},
                                        .end_moved_m = {-0.006, 0.0, 0.0},
                                        .radius_m = 0.012};
    for (int i = 0; i < 20; ++i)
        tool.update({&pressing, 1}, stage.breath, 0.1);
    stage.deformed.press(&tool.table());
    stage.tool = &tool.table();
    stage.add("tool", 1.0, usual, exact(), "and a tool presses in the beam");
    stage.deformed.press(nullptr);
    stage.tool = nullptr;
    stage.input.contrast = nullptr;
}

// Rows for needles in the still patient: the time of a picture with one, and the error of the attenuation
// summed across its shaft at many sub-pixel positions.
void needleRows(Stage& stage) {
    struct Gauge {
        int gauge;
        double radius_m;
    };
    FluoroscopySettings settings;
    settings.skips.between_pulses = false;
    render::Fluoroscopy fluoroscopy(stage.gpu, stage.deformed);
    const auto paths = [&](std::span<const render::XrayShape> shapes) {
        stage.input.shapes = shapes;
        fluoroscopy.image(stage.input, settings);
        stage.input.shapes = {};
        return std::vector<double>(fluoroscopy.paths().begin(), fluoroscopy.paths().end());
    };
    const std::vector<double> without = paths({});
    for (const Gauge& needle :
         {Gauge{17, 0.00075}, Gauge{18, 0.000635}, Gauge{21, 0.00041}, Gauge{22, 0.00036}}) {
        std::vector<double> times_ms;
        const auto alone = [&](const render::XrayShape& shaft) {
            std::vector<double> found;
            times_ms.push_back(medianTime_ms(1, [&] { found = paths({&shaft, 1}); }));
            for (std::size_t i = 0; i < found.size(); ++i)
                found[i] -= without[i];
            return found;
        };
        double area = 0.0, flicker = 0.0;
        for (const double turned_rad : {0.0, 0.5, 0.75}) {
            const test::ShaftErrors errors =
                test::shaftErrors(alone, settings, needle.radius_m, turned_rad, 0.2,
                                  stage.input.patient_from_isocentre.position_m);
            area = std::max(area, errors.area), flicker = std::max(flicker, errors.flicker);
        }
        std::ranges::nth_element(times_ms, times_ms.begin() + std::ptrdiff_t(times_ms.size() / 2));
        stage.rows.push_back({"imaging.fluoroscopy", "needle_gauge", double(needle.gauge),
                              times_ms[times_ms.size() / 2], area, "of the shaft's attenuation",
                              "closed form",
                              fmt::format("still, densest pixel varies by {:.0f} %", 100.0 * flicker)});
    }
}

void run(std::vector<Row>& rows) {
    if (!hasGpu("imaging.fluoroscopy")) return;
    Stage stage(referencePatient(0.001), rows);
    stillRows(stage);
    breathingRows(stage);
    contentRows(stage);
    stage.breathe(0.0);
    needleRows(stage);
}

const Registration registration("imaging.fluoroscopy", run);

}  // namespace
}  // namespace stylet::bench
