// Session thread. Decides which sounds to play, from the state of the attempt that the trainee sees. Does not
// access an audio device.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/sound/clips.h"
#include "app/training/difficulty.h"
#include "patient/patient.h"

namespace stylet::trainer {

struct Voice {
    float gain = 0.0f;   // at 1 m from its place; 0 silences a loop
    float pitch = 1.0f;  // factor on the clip's pitch
    Vec3 stage_m{0.0};
};
// All sounds after one call of Cues::update().
struct SoundFrame {
    std::array<Voice, kSoundCount> voices;  // indexed by Sound
    std::uint32_t begun = 0;                // bits soundBit(Sound) of the sounds that this call started
    const Voice& operator[](Sound s) const { return voices[std::size_t(s)]; }
    Voice& operator[](Sound s) { return voices[std::size_t(s)]; }
};

// Positions of all sound sources in the drawn room.
struct SoundPlaces {
    Pose stage_from_patient;
    // Assumed pose of the operator's head; used until the headset reports the real one.
    Pose stage_from_operator;
    Vec3 mouth_m{0.0}, monitor_m{0.0}, tube_m{0.0}, vent_m{0.0}, entry_m{0.0};
};
SoundPlaces soundPlaces(const patient::Patient&, const OperativeField&);

// Returns the largest gain with which this sound is played, at a distance of 1 m. The gains of all sounds sum
// to less than 1, so all sounds together do not clip.
float loudestGain(Sound) noexcept;

// Heart rate of an adult at rest. The patient monitor beeps at this rate.
inline constexpr double kHeart_per_min = 72.0;

// Returns a controller pulse for these sounds, for users who cannot hear them. Cuts are not included, because
// Vibrations handles them.
std::optional<Vibration> alertPulse(const SoundFrame&);

class Cues {
  public:
    Cues(const SoundPlaces&, const training::DifficultyTable&, training::Difficulty, double tick_s);
    // Call often, in tick order. While the attempt is paused only the room is audible.
    const SoundFrame& update(const FrameState&);
    const SoundPlaces& places() const { return places_; }

  private:
    void breathe(const haptics::TickOutput&);
    void playAlerts(const training::Progress&, double t_s);
    void begin(Sound, const Vec3& stage_m);

    SoundPlaces places_;
    training::DifficultyTable difficulties_;
    training::DifficultyRules rules_;
    double tick_s_;
    SoundFrame frame_;
    std::optional<FrameState> last_;
    double breath_v_ = 0.0, breath_s_ = 0.0;  // breath.v and time at the last estimate of the air flow
    double pulsed_s_ = -1.0;                  // time of the last X-ray pulse
    double alarm_s_ = -1.0;                   // start of the last alarm
};

}  // namespace stylet::trainer
