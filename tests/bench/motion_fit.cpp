// Benchmark of the motion fit of a 4D CT. For each finest registration level, it reports the computing time
// and the remaining error of the diaphragm dome. For the error of a phase, the model is fitted without that
// phase.
#include <cstdio>
#include <cstdlib>

#include <fmt/core.h>

#include "app/modeller/motion/motion_fit.h"
#include "tests/bench/bench.h"

namespace stylet::bench {
namespace {

void run(std::vector<Row>& rows) {
    const char* data = std::getenv("STYLET_DATA");
    if (!data) {
        std::printf("  left out: STYLET_DATA is not set, there is no 4D CT\n");
        return;
    }
    for (const int finest : {4, 2, 1}) {
        if (finest == 1 && !isLongRun()) continue;  // takes a quarter of an hour
        modeller::FitSettings settings;
        settings.phases.folder = std::filesystem::path(data) / "4dct_118";
        settings.registration.finest = finest;
        const auto start = std::chrono::steady_clock::now();
        const modeller::FittedMotion fitted = modeller::fitMotion(settings);
        const double time_ms = elapsed_ms(start);
        double worst_m = 0.0, slice_m = 0.0;
        for (const modeller::PhaseReport& r : fitted.phases) {
            worst_m = std::max(worst_m, r.left_out.mean_abs_m);
            slice_m = std::max(slice_m, r.left_out.slice_mean_abs_m);
        }
        const std::string note =
            fmt::format("worst phase; {:.2f} voxels, in the slice through the dome {:.2f}",
                        worst_m / fitted.voxel_m.z, slice_m / fitted.voxel_m.z);
        rows.push_back({"patient.motion_fit", "finest level [voxels]", double(finest), time_ms, worst_m * 1e3,
                        "mm", "the dome of each phase, left out of the fit", note});
    }
}

const Registration registration("patient.motion_fit", run);

}  // namespace
}  // namespace stylet::bench
