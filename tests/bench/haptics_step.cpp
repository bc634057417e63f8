// What one tick of the simulation costs: breathing, look-up, model, output stage, hash.
#include <cmath>
#include <cstdio>

#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::bench {
namespace {

using namespace haptics;

patient::Package breathingSlabs() {
    using enum Tissue;
    patient::Package package = test::makeSlabs(
        {{skin, 0.002}, {soft, 0.018}, {fascia, 0.001}, {liver, 0.020}, {duct, 0.004}, {liver, 0.040}},
        0.001);
    package.motion = test::makeShift(-0.015);
    return package;
}

void run(std::vector<Row>& rows) {
    const patient::Package package = breathingSlabs();
    const patient::Patient patient(package);
    for (const double travel_mm : {0.02, 0.1, 1.0, 10.0}) {  // 20 mm/s is a puncture, 10 m/s a dropped device
        Simulation simulation(patient, {});
        TickInput input;
        input.device.device_from_stylus.rotation = {0.70710678118654752, 0.0, -0.70710678118654752,
                                                    0.0};  // along +x
        TickOutput out;
        NeedleEvents events;
        std::vector<double> times_us;
        double x_mm = -10.0, way = 1.0;
        for (int i = 0; i < 50000; ++i) {
            x_mm += way * travel_mm;
            if (x_mm > 60.0) way = -1.0;
            if (x_mm < -10.0) way = 1.0;
            input.device.device_from_stylus.position_m.x = 1e-3 * x_mm;
            const auto began = std::chrono::steady_clock::now();
            simulation.step(input, out, events);
            times_us.push_back(1e3 * elapsed_ms(began));
        }
        char note[96];
        std::snprintf(note, sizeof note, "median %.2f us, p99 %.2f us, longest %.0f us", median(times_us),
                      quantile(times_us, 0.99), quantile(times_us, 1.0));
        rows.push_back({"haptics.step", "travel per tick [mm]", travel_mm, 1e-3 * median(times_us),
                        quantile(times_us, 0.99), "us p99", "1,000 us of a tick", note});
    }
}

// The hand with each tool as in a procedure: at 20 mm/s into the skin and 30 mm beyond for what punctures, 3
// mm for what presses, sliding all the while, then back.
void stepTool(const patient::Patient& patient, Tool tool, const char* name, std::vector<Row>& rows) {
    SimulationSettings settings;
    settings.tools.first = tool;
    Simulation simulation(patient, settings);
    TickInput input;
    input.device.device_from_stylus.rotation = {0.70710678118654752, 0.0, -0.70710678118654752, 0.0};
    TickOutput out;
    NeedleEvents events;
    std::vector<double> times_us;
    const double deepest_m = holdsNeedle(tool) ? 0.030 : 0.003;
    double x_m = -0.005, way_m = 20e-6;
    for (int i = 0; i < 60000; ++i) {
        x_m += way_m;
        if (x_m > deepest_m) way_m = -20e-6;
        if (x_m < -0.005) way_m = 20e-6;
        input.device.device_from_stylus.position_m = {x_m, 0.004 * std::sin(0.001 * i), 0.0};
        const auto began = std::chrono::steady_clock::now();
        simulation.step(input, out, events);
        times_us.push_back(1e3 * elapsed_ms(began));
    }
    char note[96];
    std::snprintf(note, sizeof note, "median %.2f us, p99.9 %.2f us", median(times_us),
                  quantile(times_us, 0.999));
    rows.push_back({std::string("haptics.step.") + name, "rate [Hz]", 1000.0, 1e-3 * median(times_us),
                    quantile(times_us, 0.999), "us p99.9", "1,000 us of a tick", note});
}

void runTools(std::vector<Row>& rows) {
    const patient::Package package = breathingSlabs();
    const patient::Patient patient(package);
    constexpr const char* kNames[kToolCount]{"finger", "probe", "scalpel", "guide", "needle"};
    for (int tool = 0; tool < kToolCount; ++tool)
        stepTool(patient, Tool(tool), kNames[tool], rows);
}

const Registration registration("haptics.step", run);
const Registration tools_registration("haptics.step.tools", runTools);

}  // namespace
}  // namespace stylet::bench
