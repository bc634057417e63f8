#include "app/trainer/sound/cues.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/trainer/attempt/staging.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

using training::Difficulty;

class CuesTest : public testing::Test {
  protected:
    FrameState at(double t_s) const {
        FrameState seen;
        seen.tick.tick = std::uint64_t(std::llround(t_s * 1000.0));
        seen.tick.breath.v = breathes_ ? 0.5 - 0.5 * std::cos(0.5 * std::numbers::pi * t_s) : 0.4;
        return seen;
    }
    // Returns how often the sound begins within `seconds`.
    int count(Sound sound, double seconds) {
        int begun = 0;
        for (double t_s = 0.0; t_s < seconds; t_s += 0.002)
            begun += (cues_.update(at(t_s)).begun & soundBit(sound)) != 0;
        return begun;
    }
    bool begins(const FrameState& seen, Sound sound) {
        return (cues_.update(seen).begun & soundBit(sound)) != 0;
    }

    patient::Package package_ = test::ductPhantom();
    patient::Patient patient_{package_};
    SoundPlaces places_ = soundPlaces(patient_, fieldOf(test::ductPath()));
    bool breathes_ = true;
    Cues cues_{places_, test::difficulties(), Difficulty::practice, 0.001};
};

TEST_F(CuesTest, TheMonitorBeepsOnceAHeartbeat) {
    EXPECT_EQ(count(Sound::beep, 50.0), std::lround(50.0 * kHeart_per_min / 60.0) - 1);
}

TEST_F(CuesTest, BreathSoundFollowsTheAirFlow) {
    float loudest = 0.0f, in_pitch = 0.0f, out_pitch = 0.0f;
    for (double t_s = 0.0; t_s < 4.0; t_s += 0.002) {
        const Voice& voice = cues_.update(at(t_s))[Sound::breath];
        loudest = std::max(loudest, voice.gain);
        if (std::fabs(t_s - 1.0) < 0.001) in_pitch = voice.pitch;
        if (std::fabs(t_s - 3.0) < 0.001) out_pitch = voice.pitch;
        if (std::fabs(t_s - 2.0) < 0.001) {
            EXPECT_LT(voice.gain, 0.05f * loudest) << "the turn of a breath";
        }
    }
    EXPECT_GT(loudest, 0.0f);
    EXPECT_GT(in_pitch, out_pitch);
}

TEST_F(CuesTest, AHeldBreathIsSilent) {
    breathes_ = false;
    for (double t_s = 0.0; t_s < 1.0; t_s += 0.002)
        EXPECT_EQ(cues_.update(at(t_s))[Sound::breath].gain, 0.0f);
}

TEST_F(CuesTest, TheTubeBuzzesWhileItPulses) {
    std::uint64_t pulses = 0;
    for (double t_s = 0.0; t_s < 6.0; t_s += 0.002) {
        FrameState seen = at(t_s);
        seen.equipment.xray.pedal = t_s > 1.0 && t_s < 3.0;
        if (seen.equipment.xray.pedal) pulses = 1 + std::uint64_t((t_s - 1.0) * 7.5);
        seen.equipment.xray.pulses = pulses;
        const bool buzzes = cues_.update(seen)[Sound::buzz].gain > 0.0f;
        const bool settled = std::fabs(t_s - 1.0) > 0.01 && std::fabs(t_s - 3.0) > 0.01;
        EXPECT_TRUE(!settled || buzzes == seen.equipment.xray.pedal) << t_s;
    }
}

TEST_F(CuesTest, ToolSoundsComeFromTheTool) {
    cues_.update(at(0.1));
    FrameState snapped = at(0.102);
    snapped.tick.needle_in_guide = true;
    snapped.tick.patient_from_tool.position_m = {0.01, 0.02, 0.03};
    EXPECT_TRUE(begins(snapped, Sound::click));
    snapped.tick.tick += 2;
    const SoundFrame& heard = cues_.update(snapped);
    EXPECT_EQ(heard.begun & soundBit(Sound::click), 0u) << "once";
    EXPECT_EQ(heard[Sound::click].stage_m, places_.stage_from_patient * Vec3(0.01, 0.02, 0.03));
}

TEST_F(CuesTest, CutAndPunctureHaveSounds) {
    FrameState seen = at(0.1);
    cues_.update(seen);
    seen.tick.tick += 2, seen.tick.incision_count = 1;
    EXPECT_TRUE(begins(seen, Sound::cut));
    seen.tick.tick += 2, seen.tick.phase = haptics::Phase::tenting;
    EXPECT_FALSE(begins(seen, Sound::tick)) << "only touched";
    seen.tick.tick += 2, seen.tick.phase = haptics::Phase::pass;
    EXPECT_TRUE(begins(seen, Sound::tick));
}

TEST_F(CuesTest, PausePlaysOnlyTheRoom) {
    for (double t_s = 0.0; t_s < 0.5; t_s += 0.002)
        cues_.update(at(t_s));
    FrameState paused = at(0.5);
    paused.ticks_paused = true;
    const SoundFrame& heard = cues_.update(paused);
    EXPECT_EQ(heard.begun, 0u);
    EXPECT_EQ(heard[Sound::breath].gain, 0.0f);
    EXPECT_GT(heard[Sound::room].gain, 0.0f);
}

TEST_F(CuesTest, TheAlarmSoundsForAsLongAsSomethingIsStruck) {
    int alarms = 0, late = 0;
    for (double t_s = 0.0; t_s < 6.0; t_s += 0.002) {
        FrameState seen = at(t_s);
        const bool struck = t_s > 2.0 && t_s < 4.0;
        seen.progress.current_risk =
            struck ? training::RiskStructure::vessel : training::RiskStructure::nothing;
        seen.progress.risk_hits = t_s > 2.0 ? 1 : 0;
        const SoundFrame& heard = cues_.update(seen);
        const bool begins = (heard.begun & soundBit(Sound::alarm)) != 0;
        alarms += begins, late += begins && !struck;
        if (begins) {
            EXPECT_TRUE(alertPulse(heard)) << "the hand is told too";
        }
    }
    EXPECT_EQ(alarms, 4);
    EXPECT_EQ(late, 0);
}

TEST_F(CuesTest, TargetChimePlaysOnce) {
    int chimes = 0;
    for (double t_s = 0.0; t_s < 4.0; t_s += 0.002) {
        FrameState seen = at(t_s);
        seen.progress.success = t_s > 1.0;
        chimes += begins(seen, Sound::chime);
    }
    EXPECT_EQ(chimes, 1);
}

// HZ-TEACH-12
TEST_F(CuesTest, ExamPlaysNoAlerts) {
    cues_ = Cues(places_, test::difficulties(), Difficulty::exam, 0.001);
    FrameState seen = at(0.1);
    cues_.update(seen);
    seen.tick.tick += 2, seen.progress.success = true,
                         seen.progress.current_risk = training::RiskStructure::lung;
    const SoundFrame& heard = cues_.update(seen);
    EXPECT_EQ(heard.begun & (soundBit(Sound::alarm) | soundBit(Sound::chime)), 0u);
    EXPECT_GT(heard[Sound::room].gain, 0.0f) << "a real room is not silent";
}

// HZ-TEACH-12
TEST_F(CuesTest, ChangeToExamStopsAlerts) {
    FrameState seen = at(0.1);
    cues_.update(seen);
    seen.tick.tick += 2, seen.progress.success = true,
                         seen.progress.current_risk = training::RiskStructure::lung;
    seen.difficulty = Difficulty::exam;
    EXPECT_EQ(cues_.update(seen).begun & (soundBit(Sound::alarm) | soundBit(Sound::chime)), 0u);
    seen.tick.tick += 2, seen.difficulty = Difficulty::guided;
    EXPECT_NE(cues_.update(seen).begun & soundBit(Sound::alarm), 0u);
}

// The patient's head is on the operator's left, and the monitor is beyond it. The X-ray tube is below the
// table.
TEST_F(CuesTest, SourcesAreAtTheirPlacesInTheRoom) {
    EXPECT_LT(places_.mouth_m.x, places_.entry_m.x);
    EXPECT_LT(places_.monitor_m.x, places_.mouth_m.x);
    EXPECT_GT(places_.monitor_m.y, 1.4);
    EXPECT_LT(places_.tube_m.y, 0.8);
}

}  // namespace
}  // namespace stylet::trainer
