#include "app/trainer/results.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "app/report/curve.h"
#include "app/report/slices.h"
#include "app/trainer/flight.h"

namespace stylet::trainer {

using haptics::NeedleEventKind;
using json = nlohmann::ordered_json;

namespace {

const char* kindName(NeedleEventKind kind) {
    return kind == NeedleEventKind::puncture ? "cut" : "entry";
}

json punctureJson(const patient::Patient& patient, const haptics::EventRecord& record) {
    const haptics::NeedleEvent& event = record.event;
    const patient::Label* label = patient.label(event.border.to_label);
    return {{"tissue", patient::tissueName(event.border.to)},
            {"kind", kindName(event.kind)},
            {"label", label ? label->name : ""},
            {"border_depth_m", event.border.depth_m},
            {"tenting_m", event.tenting_m},
            {"force_before_n", event.force_before_n},
            {"force_after_n", event.force_after_n},
            {"tick", record.tick}};
}

json controllerJson(const ControllerLog& c) {
    const double ticks = std::max(1.0, double(c.contact_ticks));
    return {{"contact_ticks", c.contact_ticks},
            {"felt_share", double(c.felt_ticks) / ticks},
            {"peak_n", c.peak_n},
            {"rms_n", std::sqrt(c.sum_n2 / ticks)}};
}

json summaryJson(const patient::Patient& patient, const AttemptFacts& facts, const SessionLog& log,
                 const LoopTotals& totals) {
    json punctures = json::array(), moments = json::array(), skips = json::object();
    for (const haptics::EventRecord& record : log.punctures)
        punctures.push_back(punctureJson(patient, record));
    for (const Moment& moment : log.moments)
        moments.push_back(
            {{"name", moment.name}, {"tick", moment.shown.tick}, {"depth_m", moment.shown.depth_m}});
    for (const auto& [name, count] : totals.pictures.skips)
        skips[name] = count;
    const haptics::LoopStats& haptics = totals.haptics;
    return {{"patient", facts.patient_name},
            {"scenario", facts.scenario},
            {"seed", facts.seed},
            {"clock", facts.clock},
            {"device", facts.device},
            {"firmware_sha256", facts.firmware_sha256},
            {"target_hit", log.target_hit()},
            {"path", {{"length_m", facts.path.length_m}, {"quality", facts.path.quality}}},
            {"moments", moments},
            {"punctures", punctures},
            {"peak_force_n", log.peak_force_n},
            {"lateral_cut_m", log.lateral_cut_m},
            {"haptics",
             {{"ticks", haptics.ticks},
              {"rate_hz", totals.elapsed_s > 0.0 ? double(haptics.ticks) / totals.elapsed_s : 0.0},
              {"late_ticks", haptics.late_ticks},
              {"page_faults", haptics.page_faults},
              {"faults", haptics.faults | log.faults},
              {"fault_names", faultNames(haptics.faults | log.faults)},
              {"flights", log.flights.size()},
              {"flights_lost", totals.flights_missed + log.more_flights},
              {"controller", controllerJson(log.controller)},
              {"max_step_us", haptics.max_step_us}}},
            {"frames", totals.pictures.frames},
            {"validation_messages", totals.pictures.validation_messages},
            {"skips", skips},
            {"state_hash", records::hexOf(log.state_hash)}};
}

std::string formatted(const char* format, double value) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::vector<report::ForceMark> cutMarks(const SessionLog& log) {
    std::vector<report::ForceMark> marks;
    for (const haptics::EventRecord& record : log.punctures) {
        const haptics::NeedleEvent& event = record.event;
        if (event.kind != NeedleEventKind::puncture) continue;
        const std::string name(patient::tissueName(event.border.to));
        marks.push_back({name + formatted(" %.2f N", event.force_before_n),
                         event.border.depth_m + event.tenting_m, event.force_before_n});
    }
    return marks;
}

// The tick whose picture the slices show: the target's puncture, else the deepest one inside the body.
const haptics::TickOutput* sliceTick(const SessionLog& log) {
    if (log.target_hit()) return &*log.target_cut;
    return log.deepest ? &*log.deepest : nullptr;
}

report::NeedlePicture needlePicture(const AttemptFacts& facts, const SessionLog& log,
                                    const haptics::TickOutput& tick) {
    report::NeedlePicture picture;
    picture.tip_m = tick.patient_from_needle.position_m;
    picture.axis = -tick.patient_from_needle.direction({0, 0, 1});
    picture.target_m = facts.path.target_m;
    picture.depth_m = tick.depth_m;
    picture.breath = tick.breath;
    picture.title =
        log.target_hit() ? "The puncture of the bile duct" : "The deepest point: no target was hit";
    picture.caption = facts.patient_name + "   |   " + facts.scenario + "   |   tip " +
                      formatted("%.1f mm deep, ", tick.depth_m * 1000.0) +
                      formatted("%.3f s", double(tick.tick) * facts.dt_s) +
                      (tick.breath_held ? ", breath held" : ", breathing");
    return picture;
}

void writeText(const std::filesystem::path& file, const std::string& text) {
    std::ofstream stream(file);
    stream << text << '\n';
    if (!stream.flush()) throw patient::DataError(file, "file", "cannot be written");
}

}  // namespace

void writeResults(const patient::Patient& patient, const AttemptFacts& facts, const SessionLog& log,
                  const LoopTotals& totals, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    report::writeCurveCsv(log.curve, facts.dt_s, folder / "force-depth.csv");
    report::drawCurve(log.curve, cutMarks(log),
                      "Force over depth: " + facts.patient_name + ", " + facts.scenario,
                      folder / "force-depth.png");
    if (const haptics::TickOutput* tick = sliceTick(log))
        report::drawSlices(patient, needlePicture(facts, log, *tick), folder / "slices.png");
    for (std::size_t i = 0; i < log.flights.size(); ++i)
        writeFlight(log.flights[i], facts.dt_s, folder / ("flight-" + std::to_string(i + 1) + ".csv"));
    writeText(folder / "summary.json",
              summaryJson(patient, facts, log, totals).dump(2, ' ', false, json::error_handler_t::replace));
}

void printResults(const AttemptFacts& facts, const SessionLog& log, const LoopTotals& totals,
                  const std::filesystem::path& folder, bool skips) {
    std::printf("%s, scenario %s, seed %llu: target %s\n", facts.patient_name.c_str(), facts.scenario.c_str(),
                static_cast<unsigned long long>(facts.seed), log.target_hit() ? "hit" : "missed");
    for (const haptics::EventRecord& record : log.punctures) {
        const haptics::NeedleEvent& event = record.event;
        if (event.kind != NeedleEventKind::puncture) continue;
        const std::string name(patient::tissueName(event.border.to));
        std::printf("  %-7s cut at %6.2f mm, %.2f mm behind its border: %.2f N -> %.2f N\n", name.c_str(),
                    (event.border.depth_m + event.tenting_m) * 1000.0, event.tenting_m * 1000.0,
                    event.force_before_n, event.force_after_n);
    }
    std::printf("  %llu ticks, %llu late, longest step %.1f us; %llu frames; state hash %s\n",
                static_cast<unsigned long long>(totals.haptics.ticks),
                static_cast<unsigned long long>(totals.haptics.late_ticks), totals.haptics.max_step_us,
                static_cast<unsigned long long>(totals.pictures.frames),
                records::hexOf(log.state_hash).c_str());
    const std::uint32_t faults = totals.haptics.faults | log.faults;
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((faults & fault.bit) != 0) std::printf("  fault %s: %s\n", fault.name, fault.text);
    if (const std::uint64_t lost = totals.flights_missed + log.more_flights)
        std::printf("  %llu more faults without a history of their own\n",
                    static_cast<unsigned long long>(lost));
    if (skips)
        for (const auto& [name, count] : totals.pictures.skips)
            std::printf("  skipped: %-20s %llu\n", name.c_str(), static_cast<unsigned long long>(count));
    std::printf("  %s\n", (folder / "summary.json").c_str());
}

}  // namespace stylet::trainer
