// Registration of the device's placement. Measures the fit time and the tip's error in the 80 mm cube. The
// fits of points vary the number of touched points: plain points (compared with theory), points at random
// places, and a device at rest, without and with all difficulties at once. The fits of motion vary the
// correlation time of the noise. Noise is given as the standard deviation of the fit's input along one axis.

#include <fmt/core.h>

#include "tests/bench/bench.h"
#include "tests/xr/registration/study.h"

namespace stylet::bench {
namespace {

using namespace xr::registration;
using study::Case;
using study::Errors;
using study::Method;

constexpr std::uint64_t kSeed = 1;

void add(const std::string& name, const std::string& knob, double value, const Case& c, int trials,
         std::vector<Row>& rows) {
    const Errors e = study::run(c, trials, kSeed);
    const std::string note = fmt::format(
        "{} trials: rms {:.3f} mm, expected {:.3f} ({:+.1f} %); 99.9 % below {:.2f} mm; FRE {:.2f} mm; "
        "{:.1f} % accepted, their mean {:.3f} mm",
        e.trials, 1e3 * e.rms_m, 1e3 * e.expected_rms_m, 100.0 * (e.rms_m / e.expected_rms_m - 1.0),
        1e3 * e.p999_m, 1e3 * e.fre_m, 100.0 * e.accepted, 1e3 * e.mean_accepted_m);
    rows.push_back(
        {name, knob, value, e.fit_ms, 1e3 * e.mean_m, "mm mean",
         c.method == Method::plain ? "truth; Fitzpatrick's error" : "truth; the fit's own prediction", note});
}

void run(std::vector<Row>& rows) {
    const int many = isLongRun() ? 10'000 : 500, motions = isLongRun() ? 10'000 : 20;
    for (const double noise_m : {0.0002, 0.0005, 0.001, 0.002}) {
        const std::string name = fmt::format("xr.registration.plain_{:.1f}mm", 1e3 * noise_m);
        for (const int points : {4, 6, 8, 12, 20})
            add(name, "points", points, {.points = points, .noise_m = noise_m}, many, rows);
    }
    for (const int points : {6, 8, 12, 20})
        add("xr.registration.places_by_chance", "points", points, {.points = points, .random_places = true},
            many, rows);
    Case c{.method = Method::held};
    for (const int points : {6, 8, 12, 20}) {
        c.points = points;
        add("xr.registration.held", "points", points, c, many, rows);
    }
    c.gimbal_m = 0.003, c.scale_error = 0.005, c.delay_s = 0.02, c.outliers = 0.1;
    for (const int points : {6, 8, 12, 20}) {
        c.points = points;
        add("xr.registration.held_hard", "points", points, c, many, rows);
    }
    c.method = Method::motion;
    for (const double correlation_time_s : {0.0, 0.1, 0.3}) {
        c.correlation_time_s = correlation_time_s;
        add("xr.registration.motion_hard", "noise lasts [s]", correlation_time_s, c, motions, rows);
    }
}

const Registration registration("xr.registration", run);

}  // namespace
}  // namespace stylet::bench
