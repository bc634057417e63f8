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
                if (isSkeleton(patient.at(foot - depth_m * outward + Vec3(0.0, 0.0, across_m), {}).tissue))
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

// A whole drainage along a wide duct at 20 mm/s: wire, dilator and drain in turn, each from the needle's
// track.
class DrainageBench {
  public:
    DrainageBench() {
        input_.device.device_from_stylus.rotation = {0.70710678118654752, 0.0, -0.70710678118654752, 0.0};
        move(0.030);  // the needle's tip into the duct
    }
    void select(Tool tool) {
        input_.add({CommandKind::tool, std::uint32_t(tool)});
        step();
    }
    void move(double travel_m) {
        const int ticks = int(std::lround(std::fabs(travel_m) / kTravel_m));
        for (int i = 0; i < ticks; ++i) {
            x_m_ += std::copysign(kTravel_m, travel_m);
            step();
        }
    }
    void wait(int ticks) {
        for (int i = 0; i < ticks; ++i)
            step();
    }
    // Row of the ticks since the last row.
    void addRow(const char* name, const std::string& note, std::vector<Row>& rows) {
        rows.push_back({name, "rate [Hz]", 1000.0, 1e-3 * median(times_us_), quantile(times_us_, 0.99),
                        "us p99", "50 us",
                        fmt::format("median {:.2f} us, p99.9 {:.2f} us; {}", median(times_us_),
                                    quantile(times_us_, 0.999), note)});
        forget();
    }
    void forget() { times_us_.clear(); }
    const TickOutput& now() const { return out_; }

  private:
    static constexpr double kTravel_m = 20e-6;  // per tick

    static patient::Package ductAlong() {
        using enum Tissue;
        return test::makeSlabs({{skin, 0.002}, {liver, 0.010}, {duct, 0.180}, {liver, 0.010}}, 0.001);
    }
    void step() {
        input_.device.device_from_stylus.position_m.x = x_m_;
        const auto began = std::chrono::steady_clock::now();
        simulation_.step(input_, out_, events_);
        times_us_.push_back(1e3 * elapsed_ms(began));
        input_.command_count = 0;
    }

    const patient::Package package_ = ductAlong();
    const patient::Patient patient_{package_};
    const patient::DuctSpace ducts_ = patient::makeDuctSpace(patient_);
    Simulation simulation_{patient_, {}, nullptr, &ducts_};
    TickInput input_;
    TickOutput out_;
    NeedleEvents events_;
    double x_m_ = -0.010;
    std::vector<double> times_us_;
};

void runDrainage(std::vector<Row>& rows) {
    DrainageBench bench;
    const auto inDuct = [&] {
        return fmt::format("{:.0f} mm of wire beyond the needle", 1e3 * bench.now().access.wire_m);
    };
    bench.select(Tool::wire);
    bench.move(0.110);
    bench.forget();
    bench.move(0.040);
    bench.move(-0.040);
    bench.addRow("haptics.step.wire", inDuct(), rows);
    bench.wait(5000);
    bench.addRow("haptics.step.wire_at_rest", inDuct(), rows);
    bench.select(Tool::needle);
    bench.move(-0.120);
    bench.select(Tool::dilator);
    bench.forget();
    bench.move(0.025);
    bench.addRow("haptics.step.dilator", fmt::format("{:.0f} mm dilated", 1e3 * bench.now().access.dilated_m),
                 rows);
    bench.move(-0.060);
    bench.select(Tool::drain);
    bench.forget();
    bench.move(0.080);
    bench.addRow("haptics.step.drain", fmt::format("{:.0f} mm of drain", 1e3 * bench.now().access.drain_m),
                 rows);
    bench.select(Tool::wire);
    bench.move(-0.200);
    bench.forget();
    bench.wait(5000);
    bench.addRow("haptics.step.drain_in_place",
                 bench.now().access.drain == DrainState::in_place ? "in place" : "NOT in place", rows);
}

const Registration registration("haptics.step", run);
const Registration drainage_registration("haptics.step.drainage", runDrainage);
const Registration tools_registration("haptics.step.tools", runTools);

}  // namespace
}  // namespace stylet::bench
