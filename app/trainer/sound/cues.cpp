#include "app/trainer/sound/cues.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "patient/package/package.h"

namespace stylet::trainer {

using haptics::TickOutput;

namespace {

constexpr std::array<float, kSoundCount> kGains{0.03f, 0.10f, 0.07f, 0.20f, 0.08f,
                                                0.15f, 0.09f, 0.15f, 0.13f};
// Positions in stage axes relative to the centre of the table, on the floor. render/room places the objects
// at the same positions. The patient's head is at -x.
constexpr Vec3 kMonitor_m{-1.38, 1.58, -0.42}, kVent_m{0.5, 2.7, -1.1};
constexpr double kMouthBeyondScan_m = 0.28, kMouthAboveTable_m = 0.16;
constexpr double kTubeBelowEntry_m = 0.55;

constexpr double kFlowEvery_s = 0.02;
constexpr double kFullFlow_per_s = 0.8;  // peak rate of v in a quiet breath at 15 breaths per minute
constexpr float kInPitch = 1.15f, kOutPitch = 0.9f;  // pitch of inhaling and exhaling
// The tube is off if it has not pulsed for this long. The slowest pulse rate is 3 per second.
constexpr double kPulsing_s = 0.4;
constexpr double kAlarmEvery_s = 0.6;
constexpr double kCutFelt_m = 0.0005;

constexpr Vibration kAlarmPulse{1.0f, 250'000'000}, kChimePulse{0.6f, 600'000'000},
    kClickPulse{0.5f, 20'000'000};

double lengthOf(const haptics::Incision& incision) {
    return glm::length(incision.end_reference_m - incision.begin_reference_m);
}

bool cuts(const TickOutput& before, const TickOutput& now) {
    if (now.incision_count > before.incision_count) return true;
    return now.incision_count > 0 &&
           lengthOf(now.newest_incision) > lengthOf(before.newest_incision) + kCutFelt_m;
}

bool yields(const TickOutput& before, const TickOutput& now) {
    if (!haptics::isNeedleTool(now.tool) || now.tool != before.tool) return false;
    if (now.phase == haptics::Phase::outside) return false;
    return before.phase == haptics::Phase::tenting &&
           (now.phase == haptics::Phase::pass || now.tissue != before.tissue);
}

}  // namespace

SoundPlaces soundPlaces(const patient::Patient& patient, const OperativeField& field) {
    SoundPlaces places;
    places.stage_from_patient = stageFromPatient(patient, field);
    places.stage_from_operator = stageFromHead(places.stage_from_patient, field, 0.0);
    const Grid& grid = patient.grid();
    const Vec3 last = grid.centre(grid.dims - 1);
    const Vec3 middle = places.stage_from_patient * (0.5 * (grid.origin_m + last));
    const Vec3 table{middle.x, 0.0, middle.z};
    places.monitor_m = table + kMonitor_m;
    places.vent_m = table + kVent_m;
    const Vec3 head = places.stage_from_patient * Vec3(0.0, 0.0, last.z + kMouthBeyondScan_m);
    places.mouth_m = {head.x, kTableHeight_m + kMouthAboveTable_m, middle.z};
    places.entry_m = places.stage_from_patient * field.entry_m;
    places.tube_m = places.entry_m - Vec3(0.0, kTubeBelowEntry_m, 0.0);
    return places;
}

float loudestGain(Sound sound) noexcept {
    return kGains[std::size_t(sound)];
}

std::optional<Vibration> alertPulse(const SoundFrame& frame) {
    if ((frame.begun & soundBit(Sound::alarm)) != 0) return kAlarmPulse;
    if ((frame.begun & soundBit(Sound::chime)) != 0) return kChimePulse;
    if ((frame.begun & soundBit(Sound::click)) != 0) return kClickPulse;
    return std::nullopt;
}

Cues::Cues(const SoundPlaces& places, const training::DifficultyTable& difficulties,
           training::Difficulty difficulty, double tick_s)
    : places_(places), difficulties_(difficulties), rules_(difficulties[difficulty]), tick_s_(tick_s) {
    for (int i = 0; i < kSoundCount; ++i)
        frame_.voices[std::size_t(i)].stage_m = places.entry_m;
    frame_[Sound::room] = {loudestGain(Sound::room), 1.0f, places.vent_m};
    frame_[Sound::breath].stage_m = places.mouth_m;
    frame_[Sound::buzz].stage_m = places.tube_m;
}

void Cues::begin(Sound sound, const Vec3& stage_m) {
    frame_.begun |= soundBit(sound);
    frame_[sound].gain = loudestGain(sound);
    frame_[sound].stage_m = stage_m;
}

// The air flow is proportional to the rate of the breathing surrogate v.
void Cues::breathe(const TickOutput& now) {
    const double t_s = tick_s_ * double(now.tick), since_s = t_s - breath_s_;
    if (since_s < kFlowEvery_s) return;
    const double flow_per_s = (now.breath.v - breath_v_) / since_s;
    breath_v_ = now.breath.v, breath_s_ = t_s;
    Voice& voice = frame_[Sound::breath];
    const double loudness = std::min(1.0, std::fabs(flow_per_s) / kFullFlow_per_s);
    voice.gain = loudestGain(Sound::breath) * float(loudness * loudness);
    voice.pitch = flow_per_s > 0.0 ? kInPitch : kOutPitch;
}

// Plays the sounds that duplicate the colour alerts.
void Cues::playAlerts(const training::Progress& now, double t_s) {
    const bool struck = now.current_risk != training::RiskStructure::nothing;
    // True also for a strike that was shorter than the interval between calls.
    const bool hit = now.risk_hits > last_->progress.risk_hits;
    if ((struck && t_s - alarm_s_ >= kAlarmEvery_s) || hit) {
        alarm_s_ = t_s;
        begin(Sound::alarm, places_.monitor_m);
    }
    if (now.success && !last_->progress.success) begin(Sound::chime, places_.entry_m);
}

const SoundFrame& Cues::update(const FrameState& seen) {
    frame_.begun = 0;
    if (seen.difficulty) rules_ = difficulties_[*seen.difficulty];
    const TickOutput& now = seen.tick;
    const double t_s = tick_s_ * double(now.tick);
    if (!last_ || seen.ticks_paused || now.tick <= last_->tick.tick) {
        if (!last_) breath_v_ = now.breath.v, breath_s_ = t_s;
        for (const Sound quiet : {Sound::breath, Sound::buzz})
            if (seen.ticks_paused) frame_[quiet].gain = 0.0f;
        if (!last_) last_ = seen;
        return frame_;
    }
    const TickOutput& before = last_->tick;
    breathe(now);
    const auto beats = [&](const TickOutput& tick) {
        return std::floor(tick_s_ * double(tick.tick) * kHeart_per_min / 60.0);
    };
    if (beats(now) > beats(before)) begin(Sound::beep, places_.monitor_m);

    const training::XrayState& xray = seen.equipment.xray;
    if (xray.pulses > last_->equipment.xray.pulses) pulsed_s_ = t_s;
    const bool pulsing = xray.pedal && pulsed_s_ >= 0.0 && t_s - pulsed_s_ < kPulsing_s;
    frame_[Sound::buzz].gain = pulsing ? loudestGain(Sound::buzz) : 0.0f;

    const Vec3 tip = places_.stage_from_patient * now.patient_from_tool.position_m;
    if (now.needle_in_guide && !before.needle_in_guide) begin(Sound::click, tip);
    if (cuts(before, now)) begin(Sound::cut, tip);
    if (yields(before, now)) begin(Sound::tick, tip);
    if (rules_.cues) playAlerts(seen.progress, t_s);
    last_ = seen;
    return frame_;
}

}  // namespace stylet::trainer
