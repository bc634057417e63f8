// Loads an attempt for a report, from its record: facts, events and result (record.json), and every tick
// (samples.bin). It makes no difference whether the attempt is in a store, in an export or in another folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/records/record.h"
#include "app/records/store.h"
#include "haptics/haptics.h"

namespace stylet::report {

// One tick of an attempt.
struct CourseRow {
    double t_s = 0.0;
    bool in_body = false;
    double depth_m = 0.0, force_n = 0.0;  // axial, of the needle
    double sent_n = 0.0;                  // magnitude of the force sent to the device
    double breath_v = 0.0;
    double clearance_m = 0.0;    // infinite outside the body
    Vec3 tip_m{0.0}, axis{0.0};  // of the needle, patient frame
    haptics::Tool tool = haptics::Tool::needle;
    patient::Tissue tissue = patient::Tissue::air;
    bool breath_held = false;
    std::uint32_t faults = 0;
};

struct LoadedAttempt {
    records::StoredAttempt stored;  // as in a store; id: the folder's name for an attempt outside a store
    records::RecordInfo record;
    haptics::NeedleSettings needle;     // force settings of its needle
    std::string needle_title;           // for people; may be empty
    bool input_only = false;            // its device exerted no force
    std::vector<CourseRow> course;      // every tick that was sampled
    std::vector<std::string> warnings;  // what could not be read, and why
    const records::AttemptResult* result() const { return stored.result ? &*stored.result : nullptr; }
};

// `folder`: of the attempt. Throws DataError if record.json or the header of inputs.bin cannot be read.
// Missing or damaged samples become a warning.
LoadedAttempt loadAttempt(const std::filesystem::path& folder);

}  // namespace stylet::report
