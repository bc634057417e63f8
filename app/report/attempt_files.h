// What a report reads of an attempt: the store's row where there is one, and the files of its folder.
//   summary.json      facts, moments, punctures          record/record.json  patient, path
//   force-depth.csv   the curve inside the body          record/samples.bin  every tick, where it was kept
//   *.png             the moments
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/records/record.h"
#include "app/records/store.h"
#include "haptics/haptics.h"

namespace stylet::report {

struct MomentRow {
    std::string name;
    std::uint64_t tick = 0;
    double depth_m = 0.0;
};

struct PunctureRow {
    std::string tissue, kind, label;  // kind: cut, entry, sideways
    std::uint64_t tick = 0;
    double border_depth_m = 0.0, tenting_m = 0.0;
    double force_before_n = 0.0, force_after_n = 0.0;
};

// What is used of summary.json.
struct Summary {
    std::string patient, scenario, device, clock, state_hash, fault_names;
    std::uint64_t seed = 0, ticks = 0, late_ticks = 0;
    bool target_hit = false;
    double path_length_m = 0.0, path_quality = 0.0;
    double peak_force_n = 0.0, lateral_cut_m = 0.0;
    double fluoroscopy_s = 0.0, air_kerma_gy = 0.0, contrast_ml = 0.0;
    double max_step_us = 0.0;
    std::vector<MomentRow> moments;
    std::vector<PunctureRow> punctures;
    std::optional<records::AttemptResult> score;  // of an attempt that was scored
};

// One tick, or what is known of it.
struct CourseRow {
    double t_s = 0.0;
    bool in_body = false;
    double depth_m = 0.0, force_n = 0.0;  // of the needle, axial
    double sent_n = 0.0;                  // what the device was given, as large as it was
    double breath_v = 0.0;
    double clearance_m = 0.0;             // not a number: not known
    patient::Vec3 tip_m{0.0}, axis{0.0};  // of the needle, patient frame
    haptics::Tool tool = haptics::Tool::needle;
    patient::Tissue tissue = patient::Tissue::air;
    bool breath_held = false;
    std::uint32_t faults = 0;
};

struct AttemptFiles {
    records::StoredAttempt stored;  // of a bare folder: what its files say, without events
    Summary summary;
    bool summarised = false;  // an attempt that was cut short has no summary
    std::optional<records::RecordInfo> record;
    std::vector<CourseRow> course;  // every tick where it was sampled, else those inside the body
    bool sampled = false;
    std::vector<std::string> complaints;  // what could not be read, and why
};

// Refuses a folder without summary and record; whatever else is missing or bad becomes a complaint. Throws
// patient::DataError.
AttemptFiles readAttempt(const records::StoredAttempt&);
// The same of a folder that no store knows.
AttemptFiles readFolder(const std::filesystem::path& folder);

// The two files by their contents; `file` is named when they are refused (patient::DataError).
Summary parseSummary(std::string_view json, const std::filesystem::path& file);
std::vector<CourseRow> parseCurve(std::string_view csv, const std::filesystem::path& file);

}  // namespace stylet::report
