// Compares the drawn tip with the true tip at display time. Measures the prediction error as a function of
// the lead time, for several windows of the velocity fit. The first input is scripted and runs through the
// real simulation: punctures, breathing, tremor, five tools. The second input is a light hand that the force
// moves, read through encoders.
#include <fmt/core.h>

#include "app/trainer/view/prediction.h"

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <memory>

#include "app/installation.h"
#include "app/trainer/attempt/attempt.h"
#include "haptics/devices/replay.h"
#include "patient/planning/planning.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
#include "tests/support/simulated_device.h"

namespace stylet::bench {
namespace {

using namespace haptics;
using test::kLightHand;
using test::makeSimulatedBody;
using test::SimulatedBody;
using test::SimulatedDevice;
using trainer::PredictionSettings;
using trainer::TipPredictor;

constexpr std::array kLeads_ms{0, 5, 11, 20, 30, 50};
constexpr std::array kWindows_ms{0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};
constexpr int kFrameTicks = 11;
constexpr double kResolution_m = 60e-6;  // position resolution of a Falcon; a Touch has about the same

// The outputs of an attempt's haptics loop, one tick per millisecond.
struct Stream {
    std::string name;
    std::vector<TickOutput> ticks;
    std::vector<TipSample> tips;
};

class Bedside {
  public:
    Stream play(const std::string& scenario, bool by_hand) const {
        const trainer::Scenario script =
            trainer::loadScenario(assetsFolder() / "scenarios" / (scenario + ".toml"));
        trainer::Attempt attempt = trainer::makeAttempt(patient_, script, path_, 1);
        std::unique_ptr<HapticDevice> device = std::make_unique<ReplayDevice>(attempt.hand, 0);
        if (by_hand) {
            SimulatedBody body = makeSimulatedBody(attempt.simulation.profile, kLightHand);
            body.resolution_m = kResolution_m;
            device = std::make_unique<SimulatedDevice>(attempt.hand, attempt.simulation.profile, body);
        }
        Simulation simulation(patient_, attempt.simulation, attempt.touchMap(), attempt.ductSpace());
        LoopChannels channels;
        LoopStats stats;
        Stream stream{scenario + (by_hand ? ", a light hand" : ""), {}, {}};
        std::size_t command = 0;
        for (std::int64_t t_ns = 0; t_ns <= attempt.hand.samples.back().t_ns; t_ns += 1'000'000) {
            while (command < attempt.hand.commands.size() && attempt.hand.commands[command].t_ns <= t_ns)
                channels.commands.push(attempt.hand.commands[command++].command);
            loopTick(simulation, *device, channels, stats, t_ns);
            TickRecord record;
            TipSample tip;
            EventRecord event;
            while (channels.events.pop(event)) {
            }
            if (channels.records.pop(record) && channels.tips.pop(tip))
                stream.ticks.push_back(record.output), stream.tips.push_back(tip);
        }
        return stream;
    }

  private:
    patient::Package package_ = referencePatient(0.002);
    patient::Patient patient_{package_};
    patient::PlannedPath path_ = patient::planPaths(patient_, {}).paths.front();
};

struct Errors {
    std::vector<double> distance_mm, angle_deg;
    std::vector<double> took_us;
};

double degrees(const Pose& a, const Pose& b) {
    const Quat q = a.rotation * glm::conjugate(b.rotation);
    const double sine = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
    return 2.0 * std::atan2(sine, std::fabs(q.w)) * 57.29577951308232;
}

void predict(const Stream& stream, const PredictionSettings& settings, int lead_ms, Errors& errors) {
    TipPredictor predictor(settings);
    const std::size_t lead = std::size_t(lead_ms);
    for (std::size_t i = 0; i + lead < stream.ticks.size(); ++i) {
        predictor.add(stream.tips[i]);
        if (i % kFrameTicks != 0) continue;
        const auto began = std::chrono::steady_clock::now();
        const TickOutput drawn =
            predictor.at(stream.ticks[i], stream.tips[i].t_ns + std::int64_t(lead) * 1'000'000);
        errors.took_us.push_back(1e3 * elapsed_ms(began));
        const TickOutput& truth = stream.ticks[i + lead];
        if (truth.tool != drawn.tool) continue;
        const Pose &a = trainer::activeToolPose(drawn), &b = trainer::activeToolPose(truth);
        errors.distance_mm.push_back(1e3 * glm::length(a.position_m - b.position_m));
        errors.angle_deg.push_back(degrees(a, b));
    }
}

void run(std::vector<Row>& rows) {
    const Bedside bedside;
    std::vector<Stream> streams;
    for (const char* scenario : {"demo", "demo-breathing", "five-tools"})
        streams.push_back(bedside.play(scenario, false));
    for (const char* scenario : {"demo", "demo-breathing"})
        streams.push_back(bedside.play(scenario, true));
    for (const int lead_ms : kLeads_ms)
        for (const double window_ms : kWindows_ms) {
            if (lead_ms == 0 && window_ms > 0.0) continue;  // nothing to predict
            PredictionSettings settings;
            const bool chosen = std::fabs(1e3 * settings.window_s - window_ms) < 1e-9;
            settings.window_s = 1e-3 * window_ms;
            Errors all;
            std::string by_stream;
            for (const Stream& stream : streams) {
                Errors one;
                predict(stream, settings, lead_ms, one);
                const std::string text =
                    fmt::format("; {}: {:.3f}", stream.name, quantile(one.distance_mm, 0.99));
                by_stream += text;
                for (auto part : {&Errors::distance_mm, &Errors::angle_deg, &Errors::took_us})
                    (all.*part).insert((all.*part).end(), (one.*part).begin(), (one.*part).end());
            }
            const std::string note = fmt::format("{}mean {:.3f} mm; {:.3f} deg, p99 {:.3f}; mm p99 of each",
                                                 chosen ? "DEFAULT; " : "", mean(all.distance_mm),
                                                 mean(all.angle_deg), quantile(all.angle_deg, 0.99));
            rows.push_back({"xr.prediction.lead_" + std::to_string(lead_ms) + "_ms", "window, ms (0: none)",
                            window_ms, 1e-3 * median(all.took_us), quantile(all.distance_mm, 0.99), "mm p99",
                            "the tip at display time", note + by_stream});
        }
}

const Registration registration("xr.prediction", run);

}  // namespace
}  // namespace stylet::bench
