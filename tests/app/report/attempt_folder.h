// Writes a made-up attempt folder of any duration.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/records/samples.h"
#include "app/report/canvas.h"
#include "patient/patient.h"
#include "tests/app/report/attempts.h"

namespace stylet::test {

inline haptics::Tissue testTissueAt(double depth_m) {
    using haptics::Tissue;
    return depth_m < 0.002   ? Tissue::skin
           : depth_m < 0.033 ? Tissue::soft
           : depth_m < 0.035 ? Tissue::fascia
           : depth_m < 0.070 ? Tissue::liver
                             : Tissue::duct;
}

// The tools change one after the other at the start. Later the needle moves in along a line and out again.
inline records::Sample makeTestSample(std::uint64_t tick, std::uint64_t ticks) {
    records::Sample s;
    const double share = double(tick) / double(ticks);
    s.tick = tick;
    s.tool = haptics::Tool(std::min(4, int(share * 12.0)));
    const double way = std::max(0.0, 1.0 - std::fabs(share - 0.7) / 0.25);
    s.depth_m = 0.074 * way;
    s.phase = way > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
    s.tissue = way > 0.0 ? testTissueAt(s.depth_m) : haptics::Tissue::air;
    s.force_n = way > 0.0 ? (share <= 0.7 ? 1.0 : -0.6) * (0.7 + 0.2 * std::sin(900.0 * s.depth_m)) : 0.0;
    s.tip_m = {0.1 - s.depth_m, 0.002 * std::sin(40.0 * share), 0.0};
    s.axis = {-1.0, 0.0, 0.0};
    s.sent_n = {0.0, 0.0, 0.4 * s.force_n};
    s.breath_held = share > 0.4 && share < 0.95;
    s.breath_v = s.breath_held ? 0.1 : 0.5 - 0.5 * std::cos(2e-3 * double(tick));
    s.clearance_m = way > 0.0 ? 0.012 - 0.01 * way : INFINITY;
    s.faults = share > 0.2 && share < 0.22 ? 1u : 0u;
    return s;
}

inline void writeAttemptFolder(const std::filesystem::path& folder, std::uint64_t ticks) {
    std::filesystem::create_directories(folder / "record");
    records::SampleWriter writer(folder / "record", {});
    for (std::uint64_t tick = 1; tick <= ticks; ++tick)
        writer.add(makeTestSample(tick, ticks));
    writer.finish();
    nlohmann::json summary = {{"patient", "reference patient, seed 7"},
                              {"scenario", "procedure"},
                              {"device", "scripted"},
                              {"clock", "virtual"},
                              {"seed", 7},
                              {"target_hit", true},
                              {"peak_force_n", 0.9},
                              {"haptics", {{"ticks", ticks}, {"late_ticks", 0}, {"fault_names", "none"}}}};
    for (const double depth_m : {0.0, 0.033, 0.07})
        summary["punctures"].push_back(
            {{"tissue", depth_m < 0.07 ? "fascia" : "duct"},
             {"kind", "cut"},
             {"label", depth_m < 0.07 ? kHostile : "bile ducts"},
             {"tick", std::uint64_t(double(ticks) * (0.45 + 0.25 * depth_m / 0.074))},
             {"border_depth_m", depth_m},
             {"tenting_m", 0.001},
             {"force_before_n", 0.8},
             {"force_after_n", 0.5}});
    std::ofstream(folder / "summary.json")
        << summary.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
    for (const char* name : {"duct_left", "duct_right", "duct_ultrasound"}) {
        report::Canvas canvas(1400, 900, {0.2, 0.3, 0.4});
        canvas.text({100, 450}, name, {90.0, {1, 1, 1}, report::Align::left, true});
        canvas.savePng(folder / (std::string(name) + ".png"));
    }
}

}  // namespace stylet::test
