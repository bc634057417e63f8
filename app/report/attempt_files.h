// Reads an attempt for a report: the store's row if there is one, and the files of its folder.
//   summary.json      facts, captures, punctures         record/record.json  patient, path
//   force-depth.csv   the curve inside the body          record/samples.bin  every tick, if recorded
//   *.png             pictures of the captures
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

struct CaptureRow {
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

// The contents of summary.json that reports use.
struct Summary {
    std::string patient, scenario, device, clock, state_hash, fault_names;
    std::uint64_t seed = 0, ticks = 0, late_ticks = 0;
    bool target_hit = false;
    double path_length_m = 0.0, path_quality = 0.0;
    double peak_force_n = 0.0, lateral_cut_m = 0.0;
    double fluoroscopy_s = 0.0, air_kerma_gy = 0.0, contrast_ml = 0.0;
    double max_step_us = 0.0;
    std::vector<CaptureRow> captures;
    std::vector<PunctureRow> punctures;
    std::optional<records::AttemptResult> score;  // only if the attempt was scored
};

// One tick of an attempt.
struct CourseRow {
    double t_s = 0.0;
    bool in_body = false;
    double depth_m = 0.0, force_n = 0.0;  // axial, of the needle
    double sent_n = 0.0;                  // magnitude of the force sent to the device
    double breath_v = 0.0;
    double clearance_m = 0.0;    // NaN: unknown
    Vec3 tip_m{0.0}, axis{0.0};  // of the needle, patient frame
    haptics::Tool tool = haptics::Tool::needle;
    patient::Tissue tissue = patient::Tissue::air;
    bool breath_held = false;
    std::uint32_t faults = 0;
};

struct AttemptFiles {
    records::StoredAttempt stored;  // for a folder outside a store: from its files, without events
    Summary summary;
    bool has_summary = false;  // false: an attempt that was cut short has no summary
    std::optional<records::RecordInfo> record;
    std::optional<haptics::NeedleSettings> needle;  // force settings, from the record
    std::vector<CourseRow> course;  // every tick if sampled, else only the ticks inside the body
    bool has_samples = false;
    std::vector<std::string> warnings;  // files that could not be read, and why
};

// Throws DataError for a folder without summary and record. Any other damaged file becomes a warning.
AttemptFiles readAttempt(const records::StoredAttempt&);
// The same for a folder outside a store.
AttemptFiles readFolder(const std::filesystem::path& folder);

// Parse the contents of the two files. `file` is named in errors (DataError).
Summary parseSummary(std::string_view json, const std::filesystem::path& file);
std::vector<CourseRow> parseCurve(std::string_view csv, const std::filesystem::path& file);

}  // namespace stylet::report
