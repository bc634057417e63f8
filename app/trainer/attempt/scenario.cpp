#include "app/trainer/attempt/scenario.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <string_view>

#include "app/installation.h"
#include "app/trainer/attempt/random.h"
#include "base/fields.h"
#include "base/hash.h"
#include "base/text.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::trainer {

using training::kMlPerM3;

namespace {

constexpr double kMaxSeconds = 600.0, kMaxDistance_mm = 500.0, kMaxSpeed_mm_s = 500.0;
constexpr double kMaxLean_deg = 60.0, kMaxRoll_deg = 180.0, kRadPerDeg = 0.017453292519943295;
constexpr std::size_t kMaxStages = 200, kMaxMoments = 100, kMaxInstruments = 20;
constexpr std::size_t kMaxFileBytes = 1 << 20;

constexpr std::array<std::string_view, 4> kReviewAnswerNames{"right", "wrong", "yes", "no"};
constexpr std::uint64_t kCaseStream = 0x43617365;

double metres(double mm) {
    return mm / 1000.0;
}

Place readPlace(Fields& f) {
    Place place;
    if (f.has("share")) place.share = f.number("share", 0.0, 1.0);
    if (f.has("capsule_share")) {
        if (f.has("share")) f.refuse("capsule_share", "share is given too");
        place.share = f.number("capsule_share", 0.0, 1.0);
        place.to_capsule = true;
    }
    if (f.has("deeper_mm")) place.deeper_m = metres(f.number("deeper_mm", -kMaxDistance_mm, kMaxDistance_mm));
    if (!f.has("share") && !place.to_capsule && !f.has("deeper_mm"))
        f.refuse("share", "share, capsule_share or deeper_mm is needed");
    place.headward_m = metres(f.numberOr("headward_mm", -kMaxDistance_mm, kMaxDistance_mm, 0.0));
    place.frontward_m = metres(f.numberOr("frontward_mm", -kMaxDistance_mm, kMaxDistance_mm, 0.0));
    place.headward_rad = kRadPerDeg * f.numberOr("headward_deg", -kMaxLean_deg, kMaxLean_deg, 0.0);
    place.frontward_rad = kRadPerDeg * f.numberOr("frontward_deg", -kMaxLean_deg, kMaxLean_deg, 0.0);
    place.roll_rad = kRadPerDeg * f.numberOr("roll_deg", -kMaxRoll_deg, kMaxRoll_deg, 0.0);
    return place;
}

haptics::Tool readTool(Fields& f) {
    return f.choice<haptics::Tool>("tool", haptics::kToolNames);
}

// Reads every knob that occurs in the stage. At least one is required.
std::vector<training::KnobSetting> readKnobs(Fields& f, training::Machine machine) {
    const std::span<const training::Knob> knobs = training::machineKnobs(machine);
    std::vector<training::KnobSetting> turned;
    for (std::size_t i = 0; i < knobs.size(); ++i)
        if (f.has(knobs[i].name))
            turned.push_back({machine, i, f.number(knobs[i].name, knobs[i].low, knobs[i].high)});
    f.finish();
    if (turned.empty()) f.refuse("do", "at least one knob is needed");
    return turned;
}

Stage readStage(Fields& f) {
    Stage stage;
    const std::string kind = f.text("do");
    if (kind == "inject" || kind == "numb") {
        const bool contrast = kind == "inject";
        const double most =
            contrast ? training::kMaxInjectionRate_m3_per_s : training::kMaxAnaestheticRate_m3_per_s;
        stage.kind = contrast ? StageKind::inject : StageKind::numb;
        stage.injected_m3_per_s = f.number("ml_per_s", 0.0, most * kMlPerM3) / kMlPerM3;
        stage.seconds = f.numberOr("seconds", 0.0, kMaxSeconds, 0.0);
    } else if (kind == "pedal") {
        stage.kind = StageKind::pedal;
        stage.pedal_down = f.flag("down");
    } else if (kind == "xray" || kind == "ultrasound") {
        stage.kind = StageKind::machine;
        stage.turned = readKnobs(f, kind == "xray" ? training::Machine::xray : training::Machine::ultrasound);
    } else if (kind == "move") {
        stage.kind = StageKind::move;
        stage.to = readPlace(f);
        stage.speed_m_s = metres(f.number("speed_mm_s", 0.1, kMaxSpeed_mm_s));
    } else if (kind == "take") {
        stage.kind = StageKind::changeTool;
        stage.tool = readTool(f);
        stage.seconds = f.number("seconds", 0.1, kMaxSeconds);
    } else if (kind == "breathe" || kind == "park" || kind == "lift" || kind == "aspirate") {
        stage.kind = kind == "breathe" ? StageKind::breathe
                     : kind == "park"  ? StageKind::park
                     : kind == "lift"  ? StageKind::lift
                                       : StageKind::aspirate;
    } else if (kind == "review") {
        stage.kind = StageKind::review;
        if (f.has("answers")) stage.answers = f.choice<ReviewAnswers>("answers", kReviewAnswerNames);
    } else if (kind == "wait" || kind == "hold") {
        stage.kind = kind == "hold" ? StageKind::hold : StageKind::wait;
        stage.seconds = f.number("seconds", 0.0, kMaxSeconds);
    } else {
        f.refuse("do",
                 "\"" + kind +
                     "\" is none of wait, move, hold, breathe, take, park, lift, aspirate, inject, numb, "
                     "pedal, xray, ultrasound, review");
    }
    f.finish();
    return stage;
}

bool isTissue(const std::string& name) {
    return findEnum<patient::Tissue>(patient::kTissueNames, name).has_value();
}

std::vector<std::string> readMoments(Fields& f) {
    std::vector<std::string> moments = f.texts("moments", kMaxMoments);
    for (auto name = moments.begin(); name != moments.end(); ++name) {
        if (*name != "approach" && *name != "xray" && *name != "contrast" && !isTissue(*name))
            f.refuse("moments", "each must be \"approach\", \"xray\", \"contrast\" or a tissue");
        if (std::find(moments.begin(), name, *name) != name)
            f.refuse("moments", "\"" + *name + "\" is listed twice");
    }
    return moments;
}

std::vector<std::string> readInstruments(Fields& f) {
    std::vector<std::string> names = f.texts("instruments", kMaxInstruments);
    if (std::ranges::any_of(names, [](const std::string& name) { return name.empty(); }))
        f.refuse("instruments", "contains an empty name");
    return names;
}

void readHold(Fields f, ScenarioBreath& breath) {
    patient::HoldBehaviour& hold = breath.plan.hold;
    breath.creep_m = metres(f.numberOr("creep_mm", 0.0, 20.0, 0.0));
    hold.creep_s = f.numberOr("creep_s", 1.0, kMaxSeconds, hold.creep_s);
    hold.missed = f.numberOr("missed", 0.0, 0.9, 0.0);
    hold.level_v = f.numberOr("level", 0.0, 1.0, 0.0);
    hold.limit_s = f.numberOr("limit_s", 0.0, kMaxSeconds, 0.0);
    f.finish();
}

ScenarioBreath readBreath(Fields f) {
    ScenarioBreath breath;
    if (f.has("period_s")) breath.period_s = f.number("period_s", 1.0, 20.0);
    if (f.has("amplitude")) breath.amplitude = f.number("amplitude", 0.0, 2.0);
    patient::BreathPlan& plan = breath.plan;
    plan.period_jitter = f.numberOr("period_jitter", 0.0, 0.3, 0.0);
    plan.depth_jitter = f.numberOr("depth_jitter", 0.0, 0.3, 0.0);
    plan.sighs = f.numberOr("sighs", 0.0, 0.5, 0.0);
    plan.coughs = f.numberOr("coughs", 0.0, 0.5, 0.0);
    if (f.has("recording")) {
        for (const char* key : {"period_s", "period_jitter", "depth_jitter", "sighs", "coughs"})
            if (f.has(key)) f.refuse(key, "a recording breathes as it was recorded");
        breath.recording = f.file().parent_path() / f.nonEmptyText("recording");
    }
    if (f.has("hold")) readHold(f.child("hold"), breath);
    f.finish();
    return breath;
}

}  // namespace

std::filesystem::path scenarioFile(const std::string& name) {
    return assetFile("scenario", name);
}

Scenario loadScenario(const std::filesystem::path& toml) {
    Scenario scenario = parseScenario(readWholeFile(toml, kMaxFileBytes), toml);
    if (!scenario.breath.recording.empty())
        breatheAsRecorded(scenario.breath, std::filesystem::path(scenario.breath.recording));
    if (!scenario.case_name.empty())
        scenario.patient_case = std::make_shared<const training::PatientCase>(
            training::loadCase(assetFile("case", scenario.case_name)));
    return scenario;
}

void breatheAsRecorded(ScenarioBreath& breath, const std::filesystem::path& csv) {
    const patient::RecordedBreath recorded = patient::loadRecordedBreath(csv);
    breath.recording = csv;
    breath.plan.recording_v = recorded.v;
    breath.plan.recording_dt_s = recorded.dt_s;
}

Scenario parseScenario(std::string_view text, const std::filesystem::path& file) {
    Fields top = parseToml(file, text);
    top.ignore("description");
    Scenario s;
    s.name = top.nonEmptyText("name");
    s.moments = readMoments(top);
    s.approach_distance_m = metres(top.number("approach_distance_mm", 0.0, kMaxDistance_mm));
    if (top.has("course")) s.course = top.choice<training::Course>("course", training::kCourseNames);
    if (top.has("tool")) s.tool = readTool(top);
    if (haptics::isAccessTool(s.tool)) top.refuse("tool", "a scenario cannot begin with it");
    if (top.has("needle")) s.needle = top.nonEmptyText("needle");
    if (top.has("instruments")) s.instruments = readInstruments(top);
    if (top.has("case")) {
        s.case_name = top.nonEmptyText("case");
        if (s.course != training::Course::drainage) top.refuse("case", "only a drainage has one");
    }
    if (top.has("breath")) s.breath = readBreath(top.child("breath"));
    Fields start = top.child("start");
    s.start = readPlace(start);
    start.finish();

    Fields hand = top.child("hand");
    s.ramp_s = hand.number("ramp_s", 0.01, 10.0);
    s.tremor_m = metres(hand.number("tremor_mm", 0.0, 5.0));
    s.tremor_low_hz = hand.number("tremor_low_hz", 0.0, 50.0);
    s.tremor_high_hz = hand.number("tremor_high_hz", s.tremor_low_hz, 50.0);
    hand.finish();

    for (Fields& stage : top.childrenOrNone("stage", kMaxStages))
        s.stages.push_back(readStage(stage));
    if (s.stages.empty()) top.refuse("stage", "at least one [[stage]] is needed");
    top.finish();
    return s;
}

void drawCase(Scenario& scenario, std::uint64_t seed) {
    if (scenario.course != training::Course::drainage || scenario.patient_case) return;
    const std::filesystem::path folder = assetsFolder() / "cases";
    std::set<std::filesystem::path> files;  // sorted, because a folder's order is not defined
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".toml") files.insert(entry.path());
    if (files.empty()) throw DataError(folder, "cases", "there is none");
    Random random{seed ^ kCaseStream};
    const auto drawn = std::next(files.begin(), std::ptrdiff_t(random.next() * double(files.size())));
    scenario.patient_case = std::make_shared<const training::PatientCase>(training::loadCase(*drawn));
}

std::uint64_t digest(const Scenario& s) {
    StateHash hash;
    const auto addPlace = [&](const Place& p) {
        for (double v : {p.share, p.deeper_m, p.headward_m, p.frontward_m})
            hash.add(v);
        if (p.to_capsule) hash.add(std::uint64_t(1));
        // A place without rotation has the same hash as before rotations were added to the format.
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
        if (stage.kind == StageKind::inject || stage.kind == StageKind::numb)
            hash.add(stage.injected_m3_per_s);
        if (stage.kind == StageKind::review) hash.add(std::uint64_t(stage.answers));
        if (stage.kind == StageKind::pedal) hash.add(std::uint64_t(stage.pedal_down));
        for (const training::KnobSetting& turned : stage.turned) {
            hash.add(std::uint64_t(turned.machine) | std::uint64_t(turned.knob) << 8);
            hash.add(turned.value);
        }
    }
    if (s.course != training::kDefaultCourse) hash.add(std::uint64_t(s.course));
    // A scenario without instruments has the same hash as before instruments were added to the format.
    if (!s.needle.empty()) hash.add(std::string_view(s.needle));
    for (const std::string& name : s.instruments)
        hash.add(std::string_view(name));
    if (s.patient_case) hash.add(std::string_view(s.patient_case->toml));
    return hash.value();
}

}  // namespace stylet::trainer
