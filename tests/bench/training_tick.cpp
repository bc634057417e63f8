// Benchmark of one tick of the session: equipment, contrast medium and local anaesthetic (AttemptFold), then
// evidence, metrics, pain and score (Procedure), with depots of local anaesthetic in the patient.
#include <cmath>

#include <fmt/core.h>

#include "app/trainer/attempt/hand.h"
#include "app/training/procedure.h"
#include "tests/app/training/wall.h"
#include "tests/bench/bench.h"

namespace stylet::bench {
namespace {

using namespace training;
using haptics::TickOutput;

constexpr double kDt_s = 0.001, kDepot_m3 = 0.1e-6, kPitch_m = 0.005;
constexpr int kTicks = 20000, kRows = 16;
constexpr int kMore = 300;  // than the list has places for

class Ticks {
  public:
    explicit Ticks(Course course) { procedure_.setCourse(course); }

    // Injects depots side by side, too far apart to become one.
    void addDepots(int count) {
        haptics::TickInput start, stop;
        start.add(anaesthetiseCommand(2e-6)), stop.add(anaesthetiseCommand(0.0));
        for (int d = 0; d < count; ++d) {
            const TickOutput now = needleAt({0.010, kPitch_m * (d / kRows), kPitch_m * (d % kRows)});
            step(start, now);
            for (double left_m3 = kDepot_m3; left_m3 > 0.0; left_m3 -= 2e-6 * kDt_s)
                step({}, now);
            step(stop, now);
        }
    }
    // The needle lies in the wall, or a dilator widens it, which looks up how numb each place is.
    Row measure(const char* name, int depots, bool dilates) {
        addDepots(depots);
        TickOutput now = needleAt({0.010, 0.0, 0.0});
        now.access.open = now.access.wire_in = dilates;
        now.access.base_m = {0.050, 0.0, 0.0};
        std::vector<double> times_us;
        for (int i = 0; i < kTicks; ++i) {
            if (dilates) now.access.dilator_m = 0.015 * (i + 1) / kTicks;
            const auto began = std::chrono::steady_clock::now();
            step({}, now);
            times_us.push_back(1e3 * elapsed_ms(began));
        }
        return {
            name,
            "depots",
            double(fold_.anaesthetic().depots().size()),
            1e-3 * median(times_us),
            quantile(times_us, 0.99),
            "us p99",
            "50 us",
            fmt::format("median {:.2f} us, p99.9 {:.2f} us", median(times_us), quantile(times_us, 0.999))};
    }

  private:
    static TickOutput needleAt(const Vec3& tip_m) {
        TickOutput out;
        out.patient_from_tool = out.patient_from_needle = trainer::needlePose(tip_m, {1, 0, 0});
        out.tip_reference_m = tip_m;
        out.phase = haptics::Phase::pass;
        out.depth_m = tip_m.x, out.tissue = patient::Tissue::soft;
        return out;
    }
    void step(const haptics::TickInput& input, TickOutput now) {
        now.tick = ++tick_;
        fold_.step(input, now);
        procedure_.update(now, fold_);
    }

    const patient::Package package_ = test::wallWithVessel();
    const patient::Patient patient_{package_};
    AttemptFold fold_{patient_, kDt_s};
    Procedure procedure_{patient_, test::wallPath(), kDt_s};
    std::uint64_t tick_ = 0;
};

void run(std::vector<Row>& rows) {
    rows.push_back(Ticks(Course::puncture).measure("training.tick.puncture", 0, false));
    for (const int depots : {0, 1, kMore}) {
        rows.push_back(Ticks(Course::drainage).measure("training.tick.needle", depots, false));
        rows.push_back(Ticks(Course::drainage).measure("training.tick.dilator", depots, true));
    }
}

const Registration registration("training.tick", run);

}  // namespace
}  // namespace stylet::bench
