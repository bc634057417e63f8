#include "app/trainer/program/results.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/records/disk_linux.h"
#include "app/records/export.h"
#include "app/report/curve.h"
#include "app/report/slices.h"
#include "app/trainer/session/flight.h"
#include "app/trainer/stores/console.h"
#include "app/training/losses.h"
#include "base/hex.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::trainer {

using haptics::NeedleEventKind;
using json = nlohmann::ordered_json;
using training::kMlPerM3;

namespace {

constexpr double kGyCm2PerGyM2 = 1e4;
constexpr double kDegPerRad = 57.29577951308232;

records::PunctureRow punctureRow(const patient::Patient& patient, const haptics::EventRecord& record) {
    const haptics::NeedleEvent& event = record.event;
    const patient::Label* label = patient.label(event.border.to_label);
    return {std::string(patient::tissueName(event.border.to)),
            event.kind == NeedleEventKind::puncture ? "cut" : "entry",
            label ? label->name : "",
            record.tick,
            event.border.depth_m,
            event.tenting_m,
            event.force_before_n,
            event.force_after_n};
}

records::ForceErrorResult forceErrorResult(const ForceError& error) {
    const double ticks = std::max(1.0, double(error.ticks));
    return {error.ticks, double(error.equal_ticks) / ticks, error.rms_n(), error.largest_n,
            error.largest_depth_m};
}

// Compares the force on the partial segmentation with the force on the full one.
std::optional<records::ForceTruthResult> forceTruthResult(const ForceComparisonReading& truth) {
    if (!truth.known) return std::nullopt;
    return records::ForceTruthResult{truth.felt_is_full ? "full" : "partial", truth.insertions,
                                     forceErrorResult(truth.insertion), forceErrorResult(truth.all)};
}

json firstPictureJson(const std::optional<Start>& start, const PictureTotals& pictures) {
    if (!start || !pictures.first) return nullptr;
    return secondsBetween(start->begun, pictures.first->at);
}

json startJson(const std::optional<Start>& start, const PictureTotals& pictures) {
    if (!start) return nullptr;
    json parts{{"asked_s", secondsBetween(start->begun, start->asked)},
               {"patient_s", secondsBetween(start->asked, start->patient)},
               {"hand_s", secondsBetween(start->patient, start->hand)},
               {"pictures_s", secondsBetween(start->hand, start->pictures)},
               {"patients_made", start->made.patients},
               {"marks_made", start->made.marks},
               {"plans_made", start->made.plans},
               {"touch_maps_made", start->made.touch_maps},
               {"frame_s", nullptr},
               {"pipelines", nullptr},
               {"pipelines_s", nullptr},
               {"kept_pipeline_bytes", nullptr}};
    if (const auto& first = pictures.first) {
        parts["frame_s"] = secondsBetween(start->pictures, first->at);
        parts["pipelines"] = first->pipelines;
        parts["pipelines_s"] = 1e-3 * first->pipelines_ms;
        parts["kept_pipeline_bytes"] = first->kept_pipeline_bytes;
    }
    return parts;
}

records::StepsResult stepsResult(const training::Progress& progress) {
    records::StepsResult steps{std::string(training::stepName(training::goalOf(progress.course))),
                               {},
                               std::uint64_t(std::popcount(training::stepsOf(progress))),
                               progress.out_of_order};
    for (int s = 0; s < training::kStepCount; ++s)
        if ((progress.steps_done & 1u << s) != 0)
            steps.done.emplace_back(training::stepName(training::Step(s)));
    return steps;
}

// A metric that was not achieved is NaN.
std::vector<records::MetricRow> metricRows(const training::Score& score) {
    std::vector<records::MetricRow> rows;
    for (std::size_t i = 0; i < training::kMetricCount; ++i) {
        const training::Metric& metric = training::metricTable()[i];
        if (score.max_points[i] == 0.0) continue;  // no metric of this attempt
        rows.push_back({std::string(metric.id), std::string(metric.name), std::string(metric.unit),
                        score.values[i], score.points[i], score.max_points[i]});
    }
    return rows;
}

constexpr std::array<std::string_view, 6> kPlaceNames{"none",   "duct",      "liver",
                                                      "vessel", "elsewhere", "outside"};

records::ContrastResult contrastResult(const patient::ContrastStatus& status) {
    const patient::ContrastVolumes& v = status.volumes;
    return {std::string(enumName(kPlaceNames, status.place)),
            v.ducts_m3 * kMlPerM3,
            v.liver_m3 * kMlPerM3,
            v.vessels_m3 * kMlPerM3,
            v.pooled_m3 * kMlPerM3,
            v.washed_out_m3 * kMlPerM3,
            v.lost_m3 * kMlPerM3,
            status.tree_m3 * kMlPerM3,
            status.front_m,
            status.at_blockage};
}

records::HapticsResult hapticsResult(const SessionLog& log, const LoopTotals& totals) {
    const haptics::LoopStats& loop = totals.haptics;
    records::HapticsResult result;
    result.rate_hz = totals.elapsed_s > 0.0 ? double(loop.ticks) / totals.elapsed_s : 0.0;
    result.ticks = loop.ticks, result.max_step_us = loop.max_step_us;
    result.late_ticks = loop.late_ticks, result.page_faults = loop.page_faults;
    result.faults = loop.faults | log.faults;
    result.fault_names = faultNames(loop.faults | log.faults);
    result.flights = log.flights.size();
    result.flights_lost = totals.flights_missed + log.more_flights;
    const ControllerLog& c = log.controller;
    const double contact = std::max(1.0, double(c.contact_ticks));
    result.contact_ticks = c.contact_ticks;
    result.felt_share = double(c.felt_ticks) / contact;
    result.peak_n = c.peak_n;
    result.rms_n = std::sqrt(c.sum_n2 / contact);
    return result;
}

// Computes median, first and 99th percentile.
json spreadOf(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        return values.empty() ? json(nullptr) : json(values[lowerRank(values.size(), share)]);
    };
    return {{"p1", at(0.01)}, {"median", at(0.5)}, {"p99", at(0.99)}};
}

// Difference between the drawn tip and the true tip at the display time. `ahead_ms` > 0: the drawn tip was
// ahead of the hand.
json visuoHapticJson(const std::vector<FrameTime>& times) {
    std::vector<double> lead_ms, offset_mm, offset_deg, ahead_ms;
    std::size_t late = 0;
    for (const FrameTime& time : times) {
        late += time.late;
        if (!time.tip) continue;
        lead_ms.push_back(1e3 * time.tip->lead_s);
        offset_mm.push_back(1e3 * time.tip->distance_m);
        offset_deg.push_back(kDegPerRad * time.tip->angle_rad);
        if (time.tip->ahead_s) ahead_ms.push_back(1e3 * *time.tip->ahead_s);
    }
    return {{"frames", offset_mm.size()},
            {"moving_frames", ahead_ms.size()},
            {"late_frames", late},
            {"lead_ms", spreadOf(lead_ms)},
            {"offset_mm", spreadOf(offset_mm)},
            {"offset_deg", spreadOf(offset_deg)},
            {"ahead_ms", spreadOf(ahead_ms)}};
}

json frameTimesJson(const std::vector<FrameTime>& times) {
    const auto spread = [&](double FrameTime::* part) {
        std::vector<double> values;
        for (const FrameTime& time : times)
            values.push_back(time.*part);
        return json{{"median", lowerQuantile(values, 0.5)}, {"p99", lowerQuantile(values, 0.99)}};
    };
    return {{"whole", spread(&FrameTime::frame_ms)},
            {"opaque", spread(&FrameTime::opaque_ms)},
            {"volume", spread(&FrameTime::volume_ms)}};
}

// How the program performed: facts about the computer, not about the attempt.
json performanceJson(const std::optional<Start>& start, const PictureTotals& pictures) {
    json skips = json::object();
    for (const auto& [name, count] : pictures.skips)
        skips[name] = count;
    return {{"first_picture_s", firstPictureJson(start, pictures)},
            {"start", startJson(start, pictures)},
            {"frames", pictures.frames},
            {"frame_ms", frameTimesJson(pictures.times)},
            {"visuo_haptic", visuoHapticJson(pictures.times)},
            {"validation_messages", pictures.validation_messages},
            {"headsets_found_again", pictures.headsets_found_again},
            {"ultrasound", {{"scans", pictures.scans}, {"all_ms", pictures.ultrasound_ms}}},
            {"xray", {{"pictures", pictures.xray_pictures}, {"all_ms", pictures.xray_ms}}},
            {"skips", skips}};
}

std::vector<report::ForceMark> cutMarks(const SessionLog& log) {
    std::vector<report::ForceMark> marks;
    for (const haptics::EventRecord& record : log.punctures) {
        const haptics::NeedleEvent& event = record.event;
        if (event.kind != NeedleEventKind::puncture) continue;
        marks.push_back(
            {fmt::format("{} {:.2f} N", patient::tissueName(event.border.to), event.force_before_n),
             event.border.depth_m + event.tenting_m, event.force_before_n});
    }
    return marks;
}

// The tick shown in the slices: the puncture of the target or, without one, the deepest tick inside the body.
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
    picture.caption = fmt::format("{}   |   {}   |   tip {:.1f} mm deep, {:.3f} s, {}", facts.patient_name,
                                  facts.scenario, tick.depth_m * 1000.0, double(tick.tick) * facts.dt_s,
                                  tick.breath_held ? "breath held" : "breathing");
    return picture;
}

// Writes the rendering times of each frame, with the tick that the frame shows.
void writeFrameTimes(const std::vector<FrameTime>& times, const std::filesystem::path& file) {
    std::ostringstream stream;
    stream << "tick,frame_ms,opaque_ms,volume_ms,layer_scale,late,lead_ms,offset_mm,offset_deg,ahead_ms\n";
    for (const FrameTime& t : times) {
        stream << t.tick << ',' << t.frame_ms << ',' << t.opaque_ms << ',' << t.volume_ms << ','
               << t.layer_scale << ',' << int(t.late) << ',';
        if (t.tip)
            stream << 1e3 * t.tip->lead_s << ',' << 1e3 * t.tip->distance_m << ','
                   << kDegPerRad * t.tip->angle_rad << ',';
        else
            stream << ",,,";
        if (t.tip && t.tip->ahead_s) stream << 1e3 * *t.tip->ahead_s;
        stream << '\n';
    }
    writeWholeFile(file, stream.view());
}

}  // namespace

bool reachedNothing(const SessionLog& log, bool exam) {
    const training::DoseLedger& dose = log.dose;
    return log.punctures.empty() && !log.target_hit() && dose.fluoroscopy_s == 0.0 &&
           dose.contrast_m3 == 0.0 && dose.anaesthetic_m3 == 0.0 &&
           std::ranges::none_of(log.events, [exam](const training::SessionEvent& event) {
               return training::isDecisive(event.kind, event.text, exam);
           });
}

records::AttemptResult makeResult(const patient::Patient& patient, const SessionLog& log,
                                  const LoopTotals& totals, bool exam) {
    records::AttemptResult result{log.target_hit(), log.score.total, log.ticks, metricRows(log.score)};
    // In an exam the trainee may be the one who types "abort"; a critical error is never made unseen.
    const bool may_abort = totals.aborted && !exam && log.progress.critical_errors == 0;
    result.aborted = may_abort || ((totals.live || totals.aborted) && reachedNothing(log, exam));
    result.score_version = training::kScoreVersion;
    result.steps = stepsResult(log.progress);
    for (const Capture& capture : log.captures)
        result.captures.push_back({capture.name, capture.state.tick.tick, capture.state.tick.depth_m});
    for (const haptics::EventRecord& record : log.punctures)
        result.punctures.push_back(punctureRow(patient, record));
    result.peak_force_n = log.peak_force_n;
    result.lateral_cut_m = log.lateral_cut_m;
    result.force_truth = forceTruthResult(log.truth);
    result.dose = {log.dose.fluoroscopy_s,          log.dose.pulses,
                   log.dose.air_kerma_gy,           log.dose.dose_area_gy_m2,
                   log.dose.contrast_m3 * kMlPerM3, log.dose.anaesthetic_m3 * kMlPerM3};
    result.contrast = contrastResult(log.contrast);
    result.haptics = hapticsResult(log, totals);
    return result;
}

void writeResults(const Results& results, const SessionLog& log, const LoopTotals& totals,
                  const std::filesystem::path& folder) {
    const AttemptFacts& facts = results.facts;
    records::createPrivateFolders(folder);
    records::exportCurve(log.curve, facts.dt_s, folder / "force-depth.csv");
    report::drawCurve(log.curve, cutMarks(log),
                      "Force over depth: " + facts.patient_name + ", " + facts.scenario,
                      folder / "force-depth.png");
    if (const haptics::TickOutput* tick = sliceTick(log))
        report::drawSlices(results.patient, needlePicture(facts, log, *tick), folder / "slices.png");
    for (std::size_t i = 0; i < log.flights.size(); ++i)
        writeFlight(log.flights[i], facts.dt_s, folder / ("flight-" + std::to_string(i + 1) + ".csv"));
    if (!totals.pictures.times.empty() && std::filesystem::is_directory(folder / "record"))
        writeFrameTimes(totals.pictures.times, folder / "record" / "frames.csv");
    records::exportSummary(results.record, performanceJson(facts.start, totals.pictures),
                           folder / "summary.json");
}

namespace {

// Prints the total and the metrics that lost the most points.
void printScore(const SessionLog& log) {
    constexpr std::size_t kShown = 4;
    const training::Score& score = log.score;
    const int steps = std::popcount(training::stepsOf(log.progress));
    printResult("  score {:.1f} of 100; {} of {} steps done, {} out of order\n", score.total,
                std::popcount(log.progress.steps_done), steps, log.progress.out_of_order);
    const std::vector<training::Loss> losses = training::findLosses(score);
    for (std::size_t i = 0; i < std::min(kShown, losses.size()); ++i)
        printResult("    {}\n", training::describeLoss(losses[i], score,
                                                       std::size_t(std::popcount(log.progress.steps_done)),
                                                       std::size_t(steps)));
    for (int error = 0; error < training::kCriticalErrorCount; ++error)
        if ((log.progress.critical_errors & 1u << error) != 0)
            printResult("    critical: {}\n", training::criticalErrorName(training::CriticalError(error)));
}

}  // namespace

void printResults(const AttemptFacts& facts, const SessionLog& log, const LoopTotals& totals,
                  const std::filesystem::path& folder, bool skips) {
    printResult("{}, scenario {}, seed {}: target {}\n", facts.patient_name, facts.scenario, facts.seed,
                log.target_hit() ? "hit" : "missed");
    for (const haptics::EventRecord& record : log.punctures) {
        const haptics::NeedleEvent& event = record.event;
        if (event.kind != NeedleEventKind::puncture) continue;
        printResult("  {:<7} cut at {:6.2f} mm, {:.2f} mm behind its border: {:.2f} N -> {:.2f} N\n",
                    patient::tissueName(event.border.to), (event.border.depth_m + event.tenting_m) * 1000.0,
                    event.tenting_m * 1000.0, event.force_before_n, event.force_after_n);
    }
    printScore(log);
    if (log.truth.all.ticks > 0)
        printResult(
            "  partial against full segmentation: RMS {:.3f} N, largest {:.2f} N at {:.1f} mm, {:.1f} % "
            "equal\n",
            log.truth.all.rms_n(), log.truth.all.largest_n, 1000.0 * log.truth.all.largest_depth_m,
            100.0 * double(log.truth.all.equal_ticks) / double(log.truth.all.ticks));
    if (log.dose.anaesthetic_m3 > 0.0)
        printResult("  local anaesthetic {:.1f} ml, worst pain {:.0f} of 10\n",
                    log.dose.anaesthetic_m3 * kMlPerM3, log.progress.worst_pain);
    if (log.equipment_used) {
        const training::DoseLedger& dose = log.dose;
        const patient::ContrastVolumes& v = log.contrast.volumes;
        printResult("  X-rays {:.1f} s, {} pulses, {:.2f} mGy at the reference point, {:.3f} Gy cm2\n",
                    dose.fluoroscopy_s, dose.pulses, dose.air_kerma_gy * 1000.0,
                    dose.dose_area_gy_m2 * kGyCm2PerGyM2);
        printResult(
            "  contrast medium {:.1f} ml: ducts {:.1f}, liver {:.1f}, vessels {:.1f}, elsewhere {:.1f}, "
            "washed "
            "out {:.1f}, lost {:.1f}{}\n",
            dose.contrast_m3 * kMlPerM3, v.ducts_m3 * kMlPerM3, v.liver_m3 * kMlPerM3,
            v.vessels_m3 * kMlPerM3, v.pooled_m3 * kMlPerM3, v.washed_out_m3 * kMlPerM3, v.lost_m3 * kMlPerM3,
            log.contrast.at_blockage ? "; it stands at the obstruction" : "");
    }
    printResult("  {} ticks, {} late, longest step {:.1f} us; {} frames; state hash {}\n",
                totals.haptics.ticks, totals.haptics.late_ticks, totals.haptics.max_step_us,
                totals.pictures.frames, hexText(log.state_hash));
    const std::uint32_t faults = totals.haptics.faults | log.faults;
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((faults & fault.bit) != 0)
            printResult("  fault {}: {}\n", fault.name,
                        totals.input_only && fault.bit == haptics::kFaultDeviceLost
                            ? "the tool was not tracked for some time"
                            : fault.text);
    if (const std::uint64_t lost = totals.flights_missed + log.more_flights)
        printResult("  {} more faults without a recorded history\n", lost);
    if (skips)
        for (const auto& [name, count] : totals.pictures.skips)
            printResult("  skipped: {:<20} {}\n", name, count);
    printResult("  {}\n", (folder / "summary.json").string());
}

}  // namespace stylet::trainer
