// What an attempt resulted in: the part of record.json that is written when the attempt ends. Every reader
// (reports, store, centre) uses these types; export.h writes them into files for other programs.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace stylet {
class Fields;
}

namespace stylet::records {

// `value` is in the unit `unit`; NaN: not achieved. `points` is at most `max_points`.
struct MetricRow {
    std::string id, name, unit;
    double value = 0.0, points = 0.0, max_points = 0.0;
};

// kind: one of training::kEventKinds (app/training/progress.h).
struct EventRow {
    std::uint64_t tick = 0;
    std::string kind, text;
};

// A capture point that was reached, with the depth of the tip.
struct CaptureRow {
    std::string name;
    std::uint64_t tick = 0;
    double depth_m = 0.0;
};

// A border that the needle passed. kind: cut or entry.
struct PunctureRow {
    std::string tissue, kind, label;
    std::uint64_t tick = 0;
    double border_depth_m = 0.0, tenting_m = 0.0;
    double force_before_n = 0.0, force_after_n = 0.0;  // axial
};

struct StepsResult {
    std::string goal;               // name of the step that the course is for (training::goalOf)
    std::vector<std::string> done;  // names
    std::uint64_t of = 0, out_of_order = 0;
};

struct DoseResult {
    double fluoroscopy_s = 0.0;
    std::uint64_t pulses = 0;
    double air_kerma_gy = 0.0, dose_area_gy_m2 = 0.0, contrast_ml = 0.0, anaesthetic_ml = 0.0;
};

// Where the contrast medium is at the end.
struct ContrastResult {
    std::string last_place;
    double ducts_ml = 0.0, liver_ml = 0.0, vessels_ml = 0.0, pooled_ml = 0.0, washed_out_ml = 0.0,
           lost_ml = 0.0;
    double duct_tree_ml = 0.0, front_m = 0.0;
    bool at_stop = false;
};

// Difference between the forces on the full and on the partial segmentation.
struct ForceErrorResult {
    std::uint64_t ticks = 0;
    double equal_share = 0.0, rms_n = 0.0, largest_n = 0.0, largest_depth_m = 0.0;
};
struct ForceTruthResult {
    std::string felt;  // full or partial
    std::uint64_t insertions = 0;
    ForceErrorResult last_insertion, all_insertions;
};

// Of the 1 kHz loop and the device.
struct HapticsResult {
    double rate_hz = 0.0, max_step_us = 0.0;
    std::uint64_t ticks = 0, late_ticks = 0, page_faults = 0, faults = 0, flights = 0, flights_lost = 0;
    std::string fault_names;
    std::uint64_t contact_ticks = 0;  // of the passivity controller
    double felt_share = 0.0, peak_n = 0.0, rms_n = 0.0;
};

struct AttemptResult {
    bool target_hit = false;
    double total = 0.0;       // score, 0 to 100
    std::uint64_t ticks = 0;  // that the session received
    std::vector<MetricRow> metrics;
    // Ended by the user before anything was reached, or marked by the instructor. Not part of any statistics.
    bool aborted = false;
    // Version of the metric table (training::kScoreVersion). Records without it are of version 1.
    std::uint64_t score_version = 1;
    StepsResult steps{};
    std::vector<CaptureRow> captures{};
    std::vector<PunctureRow> punctures{};
    double peak_force_n = 0.0, lateral_cut_m = 0.0;
    DoseResult dose{};
    ContrastResult contrast{};
    std::optional<ForceTruthResult> force_truth{};  // only with a second segmentation of the patient
    HapticsResult haptics{};
};

// NaN becomes null, and an infinite number a text, because JSON has neither.
nlohmann::ordered_json resultJson(const AttemptResult&);
nlohmann::ordered_json eventsJson(const std::vector<EventRow>&);

// Every field must be there, except "aborted", the score's "version" and "anaesthetic_ml", which older
// records lack; unknown ones are refused. Throw DataError with file and field.
AttemptResult parseResult(Fields);
std::vector<EventRow> parseEvents(Fields& in, const char* key);

}  // namespace stylet::records
