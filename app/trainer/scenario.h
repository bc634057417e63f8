// What a scripted trainee does, without a coordinate: places are given along the planned path of whichever
// patient lies on the table. README of assets/scenarios lists the fields.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/training/machines.h"
#include "haptics/tool.h"
#include "patient/signal.h"

namespace stylet::trainer {

// A place on the planned path: `share` of the way from skin (0) to target (1), so much deeper, and so much
// beside it, across the path toward the patient's head and front. The tool points along the path, leant over
// at its tip so that it points toward head and front by so much, then turned about its own shaft.
struct Place {
    double share = 0.0;
    double deeper_m = 0.0;
    double headward_m = 0.0, frontward_m = 0.0;
    double headward_rad = 0.0, frontward_rad = 0.0, roll_rad = 0.0;
    friend bool operator==(const Place&, const Place&) = default;
};

enum class StageKind : std::uint8_t {
    wait,     // stay for `seconds`
    move,     // along the path to `to`
    hold,     // command a breath-hold; wait for the longest breath and `seconds` more, so that it has begun
    breathe,  // end the hold
    take,     // another tool in hand, within `seconds`
    park,     // leave the probe where it is held
    lift,     // take the parked probe off the skin
    inject,   // contrast medium for `seconds`; without, until the next such stage
    pedal,    // X-rays from now on, or no more
    machine   // turn knobs of the C-arm or of the ultrasound machine
};

struct Stage {
    StageKind kind = StageKind::wait;
    double seconds = 0.0;
    Place to;
    double speed_m_s = 0.0;                      // cruising; starts and stops are smooth
    haptics::Tool tool = haptics::Tool::needle;  // of take
    double injected_m3_per_s = 0.0;
    bool pedal_down = false;
    std::vector<training::Turned> turned;  // of machine, in the knobs' order
    friend bool operator==(const Stage&, const Stage&) = default;
};

// How the patient on the table breathes; what is absent is as in the patient's package.
struct ScenarioBreath {
    std::optional<double> period_s, amplitude;
    // All but rhythm, creep and seed, which are the patient's and the attempt's.
    patient::BreathPlan plan;
    double creep_m = 0.0;  // of the dome over plan.hold.creep_s, toward the head
    std::filesystem::path recording;
    friend bool operator==(const ScenarioBreath&, const ScenarioBreath&) = default;
};

struct Scenario {
    std::string name;
    haptics::Tool tool = haptics::Tool::needle;  // in hand at the start
    Place start;
    double ramp_s = 0.4;       // from rest to cruising speed and back
    double tremor_m = 0.0001;  // largest excursion
    double tremor_low_hz = 8.0, tremor_high_hz = 10.0;
    double approach_distance_m = 0.0;  // off the skin: the moment "approach"
    std::vector<std::string> moments;  // "approach", "xray", "contrast", or the first entry into a tissue
    ScenarioBreath breath;
    std::vector<Stage> stages;
    friend bool operator==(const Scenario&, const Scenario&) = default;
};

// A name in assets/scenarios, or a file. Throws patient::DataError that lists the names there are.
std::filesystem::path scenarioFile(const std::string& name);
// Throws patient::DataError: file, field, reason. Reads the recording it names too.
Scenario loadScenario(const std::filesystem::path& toml);
// The same by its contents, without the recording; `file` is named when they are refused.
Scenario parseScenario(std::string_view toml, const std::filesystem::path& file);

// A recording in place of the rhythm. Throws patient::DataError.
void breatheAsRecorded(ScenarioBreath&, const std::filesystem::path& csv);

// 64 bits over all of it.
std::uint64_t digest(const Scenario&);

}  // namespace stylet::trainer
