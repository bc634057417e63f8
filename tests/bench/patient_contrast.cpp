// Contrast medium and blood on the reference patient: the time of a tick and of a new injection site. Also
// measures the error in the picture against the number of repaints of the contrast table.
#include <cmath>

#include <fmt/core.h>

#include "patient/patient.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using namespace patient;
using Clock = std::chrono::steady_clock;

constexpr double kDt_s = 0.001, kRate_m3_per_s = 1e-6, kSeconds = 12.0;
constexpr int kLook_ticks = 33;  // 30 pictures per second

Package makePackage() {
    return referencePatient(isLongRun() ? 0.001 : 0.0015);
}

// Finds the rightmost voxel of a tissue, which lies in a thin branch.
Vec3 rightmostVoxel(const Patient& patient, Tissue tissue) {
    const Grid& g = patient.grid();
    Index3 best(-1);
    forEachVoxel(g, [&](const Index3& i) {
        const Label* label = patient.label(patient.package().labels[i]);
        if (label && label->tissue == tissue && label->abdominal && i.x > best.x) best = i;
    });
    return g.centre(best);
}

// Computes the optical depth along y, as seen from the front, of each column (x, z).
std::vector<double> projectAnterior(const ContrastTable& table, const Grid& patient) {
    std::vector<double> depth(std::size_t(patient.dims.x) * std::size_t(patient.dims.z), 0.0);
    const Index3 low = table.added_per_m.empty() ? Index3(0) : patient.nearest(table.grid.origin_m);
    std::size_t n = 0;
    for (int z = 0; z < table.grid.dims.z && !table.added_per_m.empty(); ++z)
        for (int y = 0; y < table.grid.dims.y; ++y)
            for (int x = 0; x < table.grid.dims.x; ++x, ++n)
                depth[std::size_t(z + low.z) * std::size_t(patient.dims.x) + std::size_t(x + low.x)] +=
                    double(table.added_per_m[n]) * patient.spacing_m.y;
    return depth;
}

double worstDifference(const std::vector<double>& a, const std::vector<double>& b) {
    double worst = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, std::fabs(a[i] - b[i]));
    return worst;
}

// Paints one injection twice: with the threshold `visible_m3`, and with threshold 0, which shows every
// drop.
Row inject(const Patient& patient, const char* place, const Vec3& tip_m, double visible_m3) {
    Contrast contrast(patient);
    ContrastPainter painter({visible_m3}), reference({0.0});
    ContrastTable table, whole;
    ContrastChanges changes;
    std::vector<double> paint_ms;
    double first_ms = 0.0, ticks_ms = 0.0, worst = 0.0;
    const int ticks = int(kSeconds / kDt_s);
    for (int i = 0; i < ticks; ++i) {
        const Clock::time_point began = Clock::now();
        contrast.step({tip_m, kRate_m3_per_s, true}, kDt_s);
        (i == 0 ? first_ms : ticks_ms) += elapsed_ms(began);
        if (i % kLook_ticks != kLook_ticks - 1) continue;
        const Clock::time_point looked = Clock::now();
        const bool moved = painter.paint(contrast, changes);
        paint_ms.push_back(elapsed_ms(looked));
        if (moved) apply(changes, table);
        if (reference.paint(contrast, changes)) apply(changes, whole);
        if (i % (kLook_ticks * 7) == kLook_ticks - 1)
            worst = std::max(worst, worstDifference(projectAnterior(table, patient.grid()),
                                                    projectAnterior(whole, patient.grid())));
    }
    const std::string note = fmt::format(
        "worst look {:.1f} ms; begins in {:.0f} ms, then {:.2f} us a tick; {} of {} looks saw nothing new",
        quantile(paint_ms, 1.0), first_ms, 1e3 * ticks_ms / (ticks - 1), painter.skipped(), paint_ms.size());
    return {std::string("patient.contrast.") + place,
            "unseen, ml",
            visible_m3 * 1e6,
            mean(paint_ms),
            worst,
            "depth",
            "optical depth of any column, every drop shown",
            note};
}

void run(std::vector<Row>& rows) {
    const Package package = makePackage();
    const Patient patient(package);
    for (const auto& [place, tissue] : {std::pair{"duct", Tissue::duct}, std::pair{"liver", Tissue::liver},
                                        std::pair{"vessel", Tissue::vessel}}) {
        const Vec3 tip_m = rightmostVoxel(patient, tissue);
        for (const double ml : {0.0, 0.02, 0.1, 0.5})
            rows.push_back(inject(patient, place, tip_m, ml * 1e-6));
    }
}

// Computes the blood's velocity, as at load, with one thread and with two.
void runFlow(std::vector<Row>& rows) {
    const Package package = makePackage();
    const Patient patient(package);
    const VesselFlow reference = makeVesselFlow(patient, {}, 1);
    for (const int threads : {1, 2}) {
        bool same = true;
        const double time_ms = medianTime_ms(
            3, [&] { same = makeVesselFlow(patient, {}, threads).velocity == reference.velocity && same; });
        rows.push_back({"patient.vessel_flow", "threads", double(threads), time_ms, same ? 0.0 : 1.0,
                        "differs", "one thread", ""});
    }
}

const Registration contrast("patient.contrast", run);
const Registration flow("patient.vessel_flow", runFlow);

}  // namespace
}  // namespace stylet::bench
