// Benchmark of one simulation tick: breathing, look-up, model, output stage, hash.
#include <cmath>

#include <fmt/core.h>

#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
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
    for (const double travel_mm : {0.02, 0.1, 1.0, 10.0}) {  // 20 mm/s: puncture; 10 m/s: dropped device
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
        const std::string note =
            fmt::format("median {:.2f} us, p99 {:.2f} us, longest {:.0f} us", median(times_us),
                        quantile(times_us, 0.99), quantile(times_us, 1.0));
        rows.push_back({"haptics.step", "travel per tick [mm]", travel_mm, 1e-3 * median(times_us),
                        quantile(times_us, 0.99), "us p99", "1,000 us of a tick", note});
    }
}

// The breathing reference patient, with the tool on the right flank, in a gap between the ribs.
struct Flank {
    Flank() {
        for (double z_m = -0.03; z_m < 0.05; z_m += 0.001) {
            foot_m = nearestSkinPoint(skin, {0.14, 0.0, z_m});
            if (isFree(foot_m, glm::normalize(skinAt(skin, foot_m).normal))) break;
        }
        out = glm::normalize(skinAt(skin, foot_m).normal);
        side = glm::normalize(glm::cross(Vec3(0.0, 0.0, 1.0), out));
        patient_from_stylus.rotation = glm::quat_cast(patient::Mat3(side, glm::cross(out, side), out));
    }
    bool isFree(const Vec3& foot, const Vec3& outward) const {
        for (double depth_m = 0.0; depth_m < 0.045; depth_m += 0.0005)
            for (const double across_m : {-0.007, 0.0, 0.007})
                if (patient.at(foot - depth_m * outward + Vec3(0.0, 0.0, across_m), {}).tissue ==
                    Tissue::bone)
                    return false;
        return true;
    }
    const patient::Package package = referencePatient(0.0015);
    const patient::Patient patient{package};
    const patient::Skin skin = makeSkin(patient, 2);
    const TouchMap map = makeTouchMap(patient, skin, 2);
    Vec3 foot_m, out, side;
    Pose patient_from_stylus;
};

// Moves a tool as in a procedure: at 20 mm/s into the skin and back, sliding sideways all the time. The
// depth is 45 mm for a tool that holds a needle and 3 mm for the others.
void stepTool(const Flank& flank, Tool tool, const char* name, std::vector<Row>& rows) {
    SimulationSettings settings;
    settings.tools.first = tool;
    Simulation simulation(flank.patient, settings, &flank.map);
    TickInput input;
    input.device.device_from_stylus = flank.patient_from_stylus;
    TickOutput out;
    NeedleEvents events;
    std::vector<double> times_us;
    const double deepest_m = isNeedleTool(tool) ? 0.045 : 0.003;
    double depth_m = -0.010, travel_m = 20e-6, peak_n = 0.0;
    for (int i = 0; i < 60000; ++i) {
        depth_m += travel_m;
        if (depth_m > deepest_m) travel_m = -20e-6;
        if (depth_m < -0.010) travel_m = 20e-6;
        input.device.device_from_stylus.position_m =
            flank.foot_m - depth_m * flank.out + 0.004 * std::sin(0.001 * i) * flank.side;
        const auto began = std::chrono::steady_clock::now();
        simulation.step(input, out, events);
        times_us.push_back(1e3 * elapsed_ms(began));
        peak_n = std::max(peak_n, glm::length(out.tool_force.force_n));
    }
    const std::string note = fmt::format("median {:.2f} us, p99.9 {:.2f} us; at most {:.2f} N",
                                         median(times_us), quantile(times_us, 0.999), peak_n);
    rows.push_back({std::string("haptics.step.") + name, "rate [Hz]", 1000.0, 1e-3 * median(times_us),
                    quantile(times_us, 0.999), "us p99.9", "1,000 us of a tick", note});
}

void runTools(std::vector<Row>& rows) {
    const Flank flank;
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel, Tool::guide, Tool::needle})
        stepTool(flank, tool, std::string(kToolNames[std::size_t(tool)]).c_str(), rows);
}

// The wire is fed down a wide duct at 20 mm/s and pulled back, from a needle in the duct.
void runWire(std::vector<Row>& rows) {
    using enum Tissue;
    const patient::Package package =
        test::makeSlabs({{skin, 0.002}, {liver, 0.010}, {duct, 0.180}, {liver, 0.010}}, 0.001);
    const patient::Patient patient(package);
    const patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    Simulation simulation(patient, {}, nullptr, &ducts);
    TickInput input;
    input.device.device_from_stylus.rotation = {0.70710678118654752, 0.0, -0.70710678118654752, 0.0};
    TickOutput out;
    NeedleEvents events;
    std::vector<double> times_us;
    double x_m = -0.010, most_m = 0.0;
    const auto step = [&](double travel_m) {
        x_m += travel_m;
        input.device.device_from_stylus.position_m.x = x_m;
        const auto began = std::chrono::steady_clock::now();
        simulation.step(input, out, events);
        if (out.tool == Tool::wire && out.access.wire_m > 0.100) times_us.push_back(1e3 * elapsed_ms(began));
        input.command_count = 0;
        most_m = std::max(most_m, out.access.wire_m);
    };
    while (x_m < 0.020)
        step(20e-6);
    input.add({CommandKind::tool, std::uint32_t(Tool::wire)});
    for (int i = 0; i < 7500; ++i)
        step(20e-6);
    for (int i = 0; i < 2000; ++i)
        step(-20e-6);
    const std::string note = fmt::format("median {:.2f} us, p99.9 {:.2f} us; {:.0f} mm of wire in the duct",
                                         median(times_us), quantile(times_us, 0.999), 1e3 * most_m);
    rows.push_back({"haptics.step.wire", "rate [Hz]", 1000.0, 1e-3 * median(times_us),
                    quantile(times_us, 0.99), "us p99", "50 us", note});
}

const Registration registration("haptics.step", run);
const Registration wire_registration("haptics.step.wire", runWire);
const Registration tools_registration("haptics.step.tools", runTools);

}  // namespace
}  // namespace stylet::bench
