#include "app/trainer/attempt/scenario.h"

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <set>
#include <sstream>
#include <string_view>

#include "app/installation.h"
#include "base/hash.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::trainer {

using training::kMlPerM3;

namespace {

constexpr double kMaxSeconds = 600.0, kMaxDistance_mm = 500.0, kMaxSpeed_mm_s = 500.0;
constexpr double kMaxLean_deg = 60.0, kMaxRoll_deg = 180.0, kRadPerDeg = 0.017453292519943295;
constexpr std::size_t kMaxStages = 200;
constexpr std::size_t kMaxFileBytes = 1 << 20;

// One TOML table, with its name for messages.
struct Fields {
    const std::filesystem::path& file;
    std::string name;  // "" for the top level
    const toml::table& table;

    std::string path(std::string_view key) const {
        return name.empty() ? std::string(key) : name + "." + std::string(key);
    }
    [[noreturn]] void refuse(std::string_view key, const std::string& reason) const {
        throw DataError(file, path(key), reason);
    }
    void allowOnly(std::initializer_list<std::string_view> keys) const {
        for (const auto& [key, node] : table)
            if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
                refuse(key.str(), "no such field");
    }
    double number(std::string_view key, double low, double high) const {
        const auto value = table[key].value<double>();
        if (!value) refuse(key, "a number is needed");
        if (!std::isfinite(*value) || *value < low || *value > high) {
            std::ostringstream range;
            range << *value << " is not within " << low << " to " << high;
            refuse(key, range.str());
        }
        return *value;
    }
    double numberOr(std::string_view key, double low, double high, double otherwise) const {
        return table.contains(key) ? number(key, low, high) : otherwise;
    }
    std::string text(std::string_view key) const {
        const auto value = table[key].value<std::string>();
        if (!value || value->empty()) refuse(key, "a text is needed");
        return *value;
    }
    Fields sub(std::string_view key) const {
        const toml::table* inner = table[key].as_table();
        if (!inner) refuse(key, "a table is needed");
        return {file, path(key), *inner};
    }
};

double metres(double mm) {
    return mm / 1000.0;
}

Place readPlace(const Fields& f) {
    Place place;
    if (f.table.contains("share")) place.share = f.number("share", 0.0, 1.0);
    if (f.table.contains("deeper_mm"))
        place.deeper_m = metres(f.number("deeper_mm", -kMaxDistance_mm, kMaxDistance_mm));
    if (!f.table.contains("share") && !f.table.contains("deeper_mm"))
        f.refuse("share", "share or deeper_mm is needed");
    place.headward_m = metres(f.numberOr("headward_mm", -kMaxDistance_mm, kMaxDistance_mm, 0.0));
    place.frontward_m = metres(f.numberOr("frontward_mm", -kMaxDistance_mm, kMaxDistance_mm, 0.0));
    place.headward_rad = kRadPerDeg * f.numberOr("headward_deg", -kMaxLean_deg, kMaxLean_deg, 0.0);
    place.frontward_rad = kRadPerDeg * f.numberOr("frontward_deg", -kMaxLean_deg, kMaxLean_deg, 0.0);
    place.roll_rad = kRadPerDeg * f.numberOr("roll_deg", -kMaxRoll_deg, kMaxRoll_deg, 0.0);
    return place;
}

haptics::Tool readTool(const Fields& f) {
    const std::string name = f.text("tool");
    for (int i = 0; i < haptics::kToolCount; ++i)
        if (haptics::kToolNames[std::size_t(i)] == name) return haptics::Tool(i);
    f.refuse("tool", "\"" + name + "\" is none of finger, probe, scalpel, guide, needle");
}

// Reads every knob that the stage names; at least one is required.
std::vector<training::Turned> readKnobs(const Fields& f, training::Machine machine) {
    const std::span<const training::Knob> knobs = training::knobsOf(machine);
    std::vector<training::Turned> turned;
    for (const auto& [key, node] : f.table) {
        if (key.str() == "do") continue;
        const bool known = std::any_of(knobs.begin(), knobs.end(),
                                       [&](const training::Knob& knob) { return knob.name == key.str(); });
        if (!known) f.refuse(key.str(), "no such field");
    }
    for (std::size_t i = 0; i < knobs.size(); ++i)
        if (f.table.contains(knobs[i].name))
            turned.push_back({machine, i, f.number(knobs[i].name, knobs[i].low, knobs[i].high)});
    if (turned.empty()) f.refuse("do", "at least one knob is needed");
    return turned;
}

// Reads a stage that operates the equipment. Returns false for any other kind.
bool readMachineStage(const Fields& f, const std::string& kind, Stage& stage) {
    if (kind == "inject") {
        f.allowOnly({"do", "ml_per_s", "seconds"});
        stage.kind = StageKind::inject;
        stage.injected_m3_per_s =
            f.number("ml_per_s", 0.0, training::kMostInjected_m3_per_s * kMlPerM3) / kMlPerM3;
        stage.seconds = f.numberOr("seconds", 0.0, kMaxSeconds, 0.0);
        return true;
    }
    if (kind == "pedal") {
        f.allowOnly({"do", "down"});
        stage.kind = StageKind::pedal;
        const toml::value<bool>* down = f.table["down"].as_boolean();
        if (!down) f.refuse("down", "true or false is needed");
        stage.pedal_down = down->get();
        return true;
    }
    if (kind != "xray" && kind != "ultrasound") return false;
    stage.kind = StageKind::machine;
    stage.turned = readKnobs(f, kind == "xray" ? training::Machine::xray : training::Machine::ultrasound);
    return true;
}

Stage readStage(const Fields& f) {
    Stage stage;
    const std::string kind = f.text("do");
    if (readMachineStage(f, kind, stage)) return stage;
    if (kind == "move") {
        f.allowOnly({"do", "share", "deeper_mm", "headward_mm", "frontward_mm", "headward_deg",
                     "frontward_deg", "roll_deg", "speed_mm_s"});
        stage.kind = StageKind::move;
        stage.to = readPlace(f);
        stage.speed_m_s = metres(f.number("speed_mm_s", 0.1, kMaxSpeed_mm_s));
        return stage;
    }
    if (kind == "take") {
        f.allowOnly({"do", "tool", "seconds"});
        stage.kind = StageKind::take;
        stage.tool = readTool(f);
        stage.seconds = f.number("seconds", 0.1, kMaxSeconds);
        return stage;
    }
    if (kind == "breathe" || kind == "park" || kind == "lift") {
        f.allowOnly({"do"});
        stage.kind = kind == "breathe" ? StageKind::breathe
                     : kind == "park"  ? StageKind::park
                                       : StageKind::lift;
        return stage;
    }
    if (kind != "wait" && kind != "hold")
        f.refuse("do", "\"" + kind +
                           "\" is none of wait, move, hold, breathe, take, park, lift, inject, pedal, xray, "
                           "ultrasound");
    f.allowOnly({"do", "seconds"});
    stage.kind = kind == "hold" ? StageKind::hold : StageKind::wait;
    stage.seconds = f.number("seconds", 0.0, kMaxSeconds);
    return stage;
}

bool isTissue(const std::string& name) {
    for (int t = 0; t < patient::kTissueCount; ++t)
        if (patient::tissueName(patient::Tissue(t)) == name) return true;
    return false;
}

std::vector<std::string> readMoments(const Fields& f) {
    const toml::array* list = f.table["moments"].as_array();
    if (!list) f.refuse("moments", "a list of texts is needed");
    std::vector<std::string> moments;
    for (const toml::node& node : *list) {
        const auto name = node.value<std::string>();
        if (!name || (*name != "approach" && *name != "xray" && *name != "contrast" && !isTissue(*name)))
            f.refuse("moments", "each must be \"approach\", \"xray\", \"contrast\" or a tissue");
        if (std::find(moments.begin(), moments.end(), *name) != moments.end())
            f.refuse("moments", "\"" + *name + "\" stands twice");
        moments.push_back(*name);
    }
    return moments;
}

void readHold(const Fields& f, ScenarioBreath& breath) {
    f.allowOnly({"creep_mm", "creep_s", "missed", "level", "limit_s"});
    patient::HoldManner& hold = breath.plan.hold;
    breath.creep_m = metres(f.numberOr("creep_mm", 0.0, 20.0, 0.0));
    hold.creep_s = f.numberOr("creep_s", 1.0, kMaxSeconds, hold.creep_s);
    hold.missed = f.numberOr("missed", 0.0, 0.9, 0.0);
    hold.level_v = f.numberOr("level", 0.0, 1.0, 0.0);
    hold.limit_s = f.numberOr("limit_s", 0.0, kMaxSeconds, 0.0);
}

ScenarioBreath readBreath(const Fields& f) {
    f.allowOnly(
        {"period_s", "amplitude", "period_jitter", "depth_jitter", "sighs", "coughs", "recording", "hold"});
    ScenarioBreath breath;
    if (f.table.contains("period_s")) breath.period_s = f.number("period_s", 1.0, 20.0);
    if (f.table.contains("amplitude")) breath.amplitude = f.number("amplitude", 0.0, 2.0);
    patient::BreathPlan& plan = breath.plan;
    plan.period_jitter = f.numberOr("period_jitter", 0.0, 0.3, 0.0);
    plan.depth_jitter = f.numberOr("depth_jitter", 0.0, 0.3, 0.0);
    plan.sighs = f.numberOr("sighs", 0.0, 0.5, 0.0);
    plan.coughs = f.numberOr("coughs", 0.0, 0.5, 0.0);
    if (f.table.contains("recording")) {
        for (const char* key : {"period_s", "period_jitter", "depth_jitter", "sighs", "coughs"})
            if (f.table.contains(key)) f.refuse(key, "a recording breathes as it was recorded");
        breath.recording = f.file.parent_path() / f.text("recording");
    }
    if (f.table.contains("hold")) readHold(f.sub("hold"), breath);
    return breath;
}

toml::table parse(std::string_view text, const std::filesystem::path& file) {
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& e) {
        std::ostringstream where;
        where << "line " << e.source().begin.line;
        throw DataError(file, where.str(), std::string(e.description()));
    }
}

std::string scenariosIn(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".toml") names.insert(entry.path().stem().string());
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "" : ", ") + name;
    return list;
}

}  // namespace

std::filesystem::path scenarioFile(const std::string& name) {
    if (name.ends_with(".toml")) return name;
    const std::filesystem::path folder = assetsFolder() / "scenarios", file = folder / (name + ".toml");
    if (std::filesystem::exists(file)) return file;
    throw DataError(folder, "scenario \"" + name + "\"", "not among: " + scenariosIn(folder));
}

Scenario loadScenario(const std::filesystem::path& toml) {
    Scenario scenario = parseScenario(readWholeFile(toml, kMaxFileBytes), toml);
    if (!scenario.breath.recording.empty())
        breatheAsRecorded(scenario.breath, std::filesystem::path(scenario.breath.recording));
    return scenario;
}

void breatheAsRecorded(ScenarioBreath& breath, const std::filesystem::path& csv) {
    const patient::RecordedBreath recorded = patient::loadRecordedBreath(csv);
    breath.recording = csv;
    breath.plan.recording_v = recorded.v;
    breath.plan.recording_dt_s = recorded.dt_s;
}

Scenario parseScenario(std::string_view text, const std::filesystem::path& file) {
    const toml::table root = parse(text, file);
    const Fields top{file, "", root};
    top.allowOnly({"name", "description", "moments", "approach_distance_mm", "tool", "breath", "start",
                   "hand", "stage"});

    Scenario s;
    s.name = top.text("name");
    s.moments = readMoments(top);
    s.approach_distance_m = metres(top.number("approach_distance_mm", 0.0, kMaxDistance_mm));
    if (root.contains("tool")) s.tool = readTool(top);
    if (root.contains("breath")) s.breath = readBreath(top.sub("breath"));
    const Fields start = top.sub("start");
    start.allowOnly(
        {"share", "deeper_mm", "headward_mm", "frontward_mm", "headward_deg", "frontward_deg", "roll_deg"});
    s.start = readPlace(start);

    const Fields hand = top.sub("hand");
    hand.allowOnly({"ramp_s", "tremor_mm", "tremor_low_hz", "tremor_high_hz"});
    s.ramp_s = hand.number("ramp_s", 0.01, 10.0);
    s.tremor_m = metres(hand.number("tremor_mm", 0.0, 5.0));
    s.tremor_low_hz = hand.number("tremor_low_hz", 0.0, 50.0);
    s.tremor_high_hz = hand.number("tremor_high_hz", s.tremor_low_hz, 50.0);

    const toml::array* stages = root["stage"].as_array();
    if (!stages || stages->empty()) top.refuse("stage", "at least one [[stage]] is needed");
    if (stages->size() > kMaxStages) top.refuse("stage", "more than " + std::to_string(kMaxStages));
    for (std::size_t i = 0; i < stages->size(); ++i) {
        const std::string name = "stage[" + std::to_string(i) + "]";
        const toml::table* table = stages->get(i)->as_table();
        if (!table) top.refuse(name, "a table is needed");
        s.stages.push_back(readStage({file, name, *table}));
    }
    return s;
}

std::uint64_t digest(const Scenario& s) {
    StateHash hash;
    const auto addPlace = [&](const Place& p) {
        for (double v : {p.share, p.deeper_m, p.headward_m, p.frontward_m})
            hash.add(v);
        // Without any rotation the hash is the same as before rotations existed.
        if (p.headward_rad == 0.0 && p.frontward_rad == 0.0 && p.roll_rad == 0.0) return;
        for (double v : {p.headward_rad, p.frontward_rad, p.roll_rad})
            hash.add(v);
    };
    hash.add(std::string_view(s.name));
    hash.add(std::uint64_t(s.tool));
    addPlace(s.start);
    for (double v : {s.ramp_s, s.tremor_m, s.tremor_low_hz, s.tremor_high_hz, s.approach_distance_m})
        hash.add(v);
    for (const std::optional<double>& v : {s.breath.period_s, s.breath.amplitude}) {
        hash.add(std::uint64_t(v.has_value()));
        hash.add(v.value_or(0.0));
    }
    patient::hashPlan(hash, s.breath.plan);
    hash.add(s.breath.creep_m);
    hash.add(std::uint64_t(s.moments.size()));
    for (const std::string& moment : s.moments)
        hash.add(std::string_view(moment));
    hash.add(std::uint64_t(s.stages.size()));
    for (const Stage& stage : s.stages) {
        hash.add(std::uint64_t(stage.kind));
        hash.add(stage.seconds);
        addPlace(stage.to);
        hash.add(stage.speed_m_s);
        hash.add(std::uint64_t(stage.tool));
        if (stage.kind == StageKind::inject) hash.add(stage.injected_m3_per_s);
        if (stage.kind == StageKind::pedal) hash.add(std::uint64_t(stage.pedal_down));
        for (const training::Turned& turned : stage.turned) {
            hash.add(std::uint64_t(turned.machine) | std::uint64_t(turned.knob) << 8);
            hash.add(turned.value);
        }
    }
    return hash.value();
}

}  // namespace stylet::trainer
