// Actions of a scripted trainee. Places are given relative to the planned path, not as coordinates, so a
// scenario works for any patient. assets/scenarios/README.md lists the fields.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/training/equipment.h"
#include "app/training/patient_case.h"
#include "app/training/progress.h"
#include "haptics/tools/tool.h"
#include "patient/motion/signal.h"

namespace stylet::trainer {

// A place relative to the planned path. `share` is the fraction of the path from skin (0) to target (1),
// or of its part up to the liver's capsule, and `deeper_m` is added to it. `headward_m` and `frontward_m` are
// offsets across the path toward the patient's head and front. The tool points along the path. It is then
// tilted at its tip by `headward_rad` and `frontward_rad`, and rolled about its own shaft by `roll_rad`.
struct Place {
    double share = 0.0;
    double deeper_m = 0.0;
    double headward_m = 0.0, frontward_m = 0.0;
    double headward_rad = 0.0, frontward_rad = 0.0, roll_rad = 0.0;
    bool to_capsule = false;  // `share` is of the part up to the capsule
    friend bool operator==(const Place&, const Place&) = default;
};

// The digest of a scenario contains the enumerators' numbers. Append, never insert.
enum class StageKind : std::uint8_t {
    wait,        // stay for `seconds`
    move,        // along the path to `to`
    hold,        // command a hold; wait for the longest breath plus `seconds`, so that the hold has begun
    breathe,     // end the hold
    changeTool,  // change to another tool within `seconds`
    park,        // leave the probe in its place
    lift,        // take the parked probe off the skin
    inject,      // inject contrast medium for `seconds`; 0: until the next inject stage
    pedal,       // press or release the X-ray pedal
    machine,     // set knobs of the C-arm or of the ultrasound machine
    aspirate,    // draw with a syringe at the needle
    numb,        // inject local anaesthetic for `seconds`; 0: until the next inject or numb stage
    review       // answer all questions about the case, if the attempt has one
};

// How a script answers the questions about a case.
enum class ReviewAnswers : std::uint8_t { right, wrong, yes, no };

struct Stage {
    StageKind kind = StageKind::wait;
    double seconds = 0.0;
    Place to{};
    double speed_m_s = 0.0;                      // cruising speed; starts and stops are smooth
    haptics::Tool tool = haptics::Tool::needle;  // for changeTool
    double injected_m3_per_s = 0.0;
    bool pedal_down = false;
    std::vector<training::KnobSetting> turned{};  // for machine, in the order of the knobs
    ReviewAnswers answers = ReviewAnswers::right;
    friend bool operator==(const Stage&, const Stage&) = default;
};

// Breathing of the patient. Absent values are read from the patient's package.
struct ScenarioBreath {
    std::optional<double> period_s, amplitude;
    // All breathing settings except three: the rhythm comes from the patient, the seed from the attempt, and
    // the creep of a breath-hold from `creep_m`.
    patient::BreathPlan plan;
    double creep_m = 0.0;  // drift of the dome toward the head over plan.hold.creep_s
    std::filesystem::path recording;
    friend bool operator==(const ScenarioBreath&, const ScenarioBreath&) = default;
};

struct Scenario {
    std::string name;
    training::Course course = training::kDefaultCourse;
    haptics::Tool tool = haptics::Tool::needle;  // tool at the start
    // Names in assets/instruments, or .toml files. A kind that is not named has its default instrument.
    std::string needle;                    // empty: the default needle
    std::vector<std::string> instruments;  // one of a kind at most
    // Of a drainage: a name in assets/cases, or a .toml file; empty: drawCase() draws one.
    std::string case_name;
    std::shared_ptr<const training::PatientCase> patient_case;  // null: nothing is reviewed
    Place start;
    double ramp_s = 0.4;       // time from rest to cruising speed, and the same from that to rest
    double tremor_m = 0.0001;  // largest excursion of the tip
    double tremor_low_hz = 8.0, tremor_high_hz = 10.0;
    double approach_distance_m = 0.0;  // distance from the skin for the capture "approach"
    // Names of capture points: "approach", "xray", "contrast", or a tissue (its first entry).
    std::vector<std::string> moments;
    ScenarioBreath breath;
    std::vector<Stage> stages;
    friend bool operator==(const Scenario&, const Scenario&) = default;
};

// Finds a scenario by its name in assets/scenarios, or as a file. Throws DataError that lists the
// available names.
std::filesystem::path scenarioFile(const std::string& name);
// Throws DataError with file, field and reason. Also reads the breath recording and the case if the scenario
// names them.
Scenario loadScenario(const std::filesystem::path& toml);
// Same from the file's text, without the recording and the case. Errors name `file`.
Scenario parseScenario(std::string_view toml, const std::filesystem::path& file);

// Replaces the rhythm with a recording. Throws DataError.
void breatheAsRecorded(ScenarioBreath&, const std::filesystem::path& csv);

// Gives a drainage without a case one of assets/cases, chosen by the seed. Throws DataError.
void drawCase(Scenario&, std::uint64_t seed);

// 64-bit hash of the scenario.
std::uint64_t digest(const Scenario&);

}  // namespace stylet::trainer
