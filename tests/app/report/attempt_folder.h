// Writes a made-up attempt folder of any duration.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/records/samples.h"
#include "app/report/canvas.h"
#include "patient/patient.h"
#include "tests/app/records/some_result.h"
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

// Punctures of an attempt of `ticks` ticks. Their labels are hostile text, but for the duct's.
inline std::vector<records::PunctureRow> makeTestPunctures(std::uint64_t ticks) {
    std::vector<records::PunctureRow> punctures;
    for (const double depth_m : {0.0, 0.033, 0.07})
        punctures.push_back(
            {depth_m < 0.07 ? "fascia" : "duct", "cut", depth_m < 0.07 ? kHostile : "bile ducts",
             std::uint64_t(double(ticks) * (0.45 + 0.25 * depth_m / 0.074)), depth_m, 0.001, 0.8, 0.5});
    return punctures;
}

// Writes the attempt's record, with the result if there is one.
inline void writeTestRecord(const std::filesystem::path& folder, const records::StoredAttempt& attempt,
                            std::uint64_t ticks) {
    records::StoredAttempt placed = attempt;
    placed.folder = folder;
    records::RecordWriter record = beginRecord(placed);
    record.addEvents(attempt.events);
    if (attempt.result) {
        records::AttemptResult result = *attempt.result;
        result.ticks = result.haptics.ticks = ticks;
        result.peak_force_n = 0.9;
        result.haptics.fault_names = "none";
        result.punctures = makeTestPunctures(ticks);
        record.finish(result);
    }
    records::SampleWriter samples(folder / "record", {attempt.info.patient_digest, attempt.info.dt_s});
    for (std::uint64_t tick = 1; tick <= ticks; ++tick)
        samples.add(makeTestSample(tick, ticks));
    samples.finish();
}

// The folder of an attempt with its record, pictures, and exports that no reader may use.
inline void writeAttemptFolder(const std::filesystem::path& folder, std::uint64_t ticks,
                               const records::StoredAttempt& attempt = makeTestAttempt("t1", "trainee-A",
                                                                                       71.0, true)) {
    writeTestRecord(folder, attempt, ticks);
    for (const char* name : {"summary.json", "force-depth.csv", "attempt.json"})
        std::ofstream(folder / name) << "an export";
    for (const char* name : {"duct_left", "duct_right", "duct_ultrasound"}) {
        report::Canvas canvas(1400, 900, {0.2, 0.3, 0.4});
        canvas.text({100, 450}, name, {90.0, {1, 1, 1}, report::Align::left, true});
        canvas.savePng(folder / (std::string(name) + ".png"));
    }
}

}  // namespace stylet::test
