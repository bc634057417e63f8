#include "app/trainer/figures/two_fasciae.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/loop/loops.h"

namespace stylet::trainer {

using patient::Tissue;

namespace {

constexpr double kPitch_m = 0.0002, kAir_m = 0.010, kDarkGroup_m = 0.0006;
constexpr std::int16_t kAirHu = -1000, kSoftHu = 40, kDarkHu = -700, kRimHu = -350;
constexpr double kHalfWidth_m = 0.02;

struct Layer {
    Tissue tissue;
    double begin_m;
};
constexpr std::array<Layer, 7> kLayers{{{Tissue::air, -kAir_m},
                                        {Tissue::skin, 0.0},
                                        {Tissue::soft, 0.002},
                                        {Tissue::fascia, 0.012},
                                        {Tissue::soft, 0.013},
                                        {Tissue::fascia, 0.023},
                                        {Tissue::liver, 0.024}}};
constexpr double kEnd_m = 0.034;

Tissue tissueAt(double x_m) {
    Tissue tissue = Tissue::air;
    for (const Layer& layer : kLayers)
        if (x_m > layer.begin_m) tissue = layer.tissue;
    return tissue;
}

std::int16_t ctOf(Tissue tissue) {
    return tissue == Tissue::air ? kAirHu : tissue == Tissue::skin ? kRimHu : kSoftHu;
}

patient::Package emptyPhantom(const patient::TissueTable& table, const patient::Thresholds& thresholds) {
    patient::Package package;
    package.tissues = table;
    package.thresholds = thresholds;
    for (int t = 1; t < patient::kTissueCount; ++t) {
        patient::Label label;
        label.id = std::uint8_t(t);
        label.name = patient::tissueName(Tissue(t));
        label.tissue = Tissue(t);
        label.role = table[std::size_t(t)].role;
        label.abdominal = Tissue(t) == Tissue::liver;
        label.provenance = "phantom";
        package.label_table.push_back(label);
    }
    const Grid grid{{int(std::lround((kAir_m + kEnd_m) / kPitch_m)), 3, 3},
                    {kPitch_m, kHalfWidth_m, kHalfWidth_m},
                    {0.5 * kPitch_m - kAir_m, -kHalfWidth_m, -kHalfWidth_m}};
    package.ct = CtVolume(grid);
    package.labels = LabelVolume(grid);
    return package;
}

template <typename Fill>
void fill(patient::Package& package, const Fill& fillVoxel) {
    for (std::size_t i = 0; i < package.ct.voxels.size(); ++i) {
        const double x_m = package.ct.grid.centre({int(i) % package.ct.grid.dims.x, 0, 0}).x;
        fillVoxel(x_m, package.ct.voxels[i], package.labels.voxels[i]);
    }
}

}  // namespace

TwoFasciae makeTwoFasciae(const patient::TissueTable& table, const patient::Thresholds& thresholds) {
    TwoFasciae phantom;
    phantom.first_fascia_m = kLayers[3].begin_m;
    phantom.second_fascia_m = kLayers[5].begin_m;
    phantom.path.entry_reference_m = phantom.path.entry_m = {0.0, 0.0, 0.0};
    phantom.path.target_reference_m = phantom.path.target_m = {0.030, 0.0, 0.0};
    phantom.path.length_m = 0.030;

    phantom.reference = emptyPhantom(table, thresholds);
    phantom.reference.name = "two fasciae, segmented in full";
    fill(phantom.reference, [](double x_m, std::int16_t& hu, std::uint8_t& label) {
        const Tissue tissue = tissueAt(x_m);
        hu = ctOf(tissue);
        label = std::uint8_t(tissue);
    });

    phantom.segmented = emptyPhantom(table, thresholds);
    phantom.segmented.name = "two fasciae, segmented in part";
    fill(phantom.segmented, [&](double x_m, std::int16_t& hu, std::uint8_t& label) {
        const Tissue tissue = tissueAt(x_m);
        hu = ctOf(tissue);
        label = tissue == Tissue::fascia || tissue == Tissue::liver ? std::uint8_t(tissue) : std::uint8_t(0);
        const double behind_m = x_m - kLayers[4].begin_m;
        if (behind_m > 0.0 && behind_m < kPitch_m) label = std::uint8_t(Tissue::fascia);
        const double before_m = phantom.second_fascia_m - x_m;
        if (before_m > 0.0 && before_m < kDarkGroup_m) hu = kDarkHu;
    });
    return phantom;
}

FasciaRun playFasciae(const patient::Package& package, const patient::PlannedPath& path,
                      const Scenario& scenario) {
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, scenario, path, 0);
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, nullptr);
    runFast(attempt, session, nullptr, 0.0, {});
    FasciaRun run;
    double deepest_m = -1.0;
    for (const report::ForceSample& s : session.log().curve) {
        if (s.depth_m <= deepest_m) continue;
        deepest_m = s.depth_m;
        run.way_in.push_back({s.depth_m, s.force_n});
    }
    for (const haptics::EventRecord& record : session.log().punctures) {
        const haptics::NeedleEvent& e = record.event;
        if (e.kind == haptics::NeedleEventKind::puncture && e.border.to == Tissue::fascia)
            run.cuts.push_back({e.border.depth_m + e.tenting_m, e.force_before_n});
    }
    return run;
}

double largestDifference_n(const FasciaRun& a, const FasciaRun& b, double begin_m, double end_m) {
    double most_n = 0.0;
    std::size_t j = 0;
    for (const report::DepthForce& at : a.way_in) {
        while (j + 1 < b.way_in.size() && b.way_in[j + 1].depth_m <= at.depth_m)
            ++j;
        if (at.depth_m < begin_m || at.depth_m > end_m || b.way_in.empty()) continue;
        most_n = std::max(most_n, std::fabs(at.force_n - b.way_in[j].force_n));
    }
    return most_n;
}

report::Comparison compareFasciae(const TwoFasciae& phantom, const FasciaRun& reference,
                                  const FasciaRun& segmented) {
    report::Comparison c;
    c.title = "Two fasciae, two segmentations";
    c.first_name = "reference: every voxel labelled";
    c.second_name = "fasciae and liver labelled, thresholds elsewhere";
    for (const Layer& layer : kLayers)
        if (layer.begin_m >= 0.0) c.tissues.push_back({layer.begin_m, layer.tissue, 0});
    c.length_m = phantom.path.length_m;
    c.first = reference.way_in;
    c.second = segmented.way_in;
    const double first_m = phantom.first_fascia_m, second_m = phantom.second_fascia_m;
    c.remarks = {
        {first_m - 0.001, first_m + 0.004, "success: in step",
         fmt::format("the mask differs, the force by {:.2f} N",
                     largestDifference_n(reference, segmented, first_m - 0.001, first_m + 0.004))},
        {second_m - 0.001, second_m + 0.004, "failure: out of step",
         fmt::format("dark voxels before it: up to {:.2f} N apart",
                     largestDifference_n(reference, segmented, second_m - 0.001, second_m + 0.004))}};
    return c;
}

}  // namespace stylet::trainer
