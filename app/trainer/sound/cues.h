// What is to be heard of an attempt: a fold over what is seen of it. Knows no device. Session thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/trainer/controller_hand.h"
#include "app/trainer/seen.h"
#include "app/trainer/sound/clips.h"
#include "app/training/difficulty.h"
#include "patient/patient.h"

namespace stylet::trainer {

struct Voice {
    float gain = 0.0f;   // at its place's first metre; of a loop 0: silent
    float pitch = 1.0f;  // of the clip's
    patient::Vec3 stage_m{0.0};
};
struct Heard {
    std::array<Voice, kSoundCount> voices;
    std::uint32_t begun = 0;  // a bit for each Sound that begins now
    const Voice& operator[](Sound s) const { return voices[std::size_t(s)]; }
    Voice& operator[](Sound s) { return voices[std::size_t(s)]; }
};

// Where it all sounds from, in the room that is drawn.
struct SoundPlaces {
    patient::Pose stage_from_patient;
    patient::Pose stage_from_operator;  // his head, while nobody says where it is
    patient::Vec3 mouth_m{0.0}, monitor_m{0.0}, tube_m{0.0}, vent_m{0.0}, entry_m{0.0};
};
SoundPlaces soundPlaces(const patient::Patient&, const patient::PlannedPath&);

// At its place's first metre, when it is at its loudest. Their sum is below 1: all at once clip nothing.
float loudestGain(Sound) noexcept;

inline constexpr double kHeart_per_min = 72.0;  // of the monitor's beep: an adult at rest

// What of it the hand that holds a controller feels too: who cannot hear is told all the same. Cuts are felt
// as Vibrations has them.
std::optional<Vibration> pulseOf(const Heard&);

class Cues {
  public:
    Cues(const SoundPlaces&, training::Difficulty, double tick_s);
    // Often, in the order of ticks. Nothing while the attempt stands still but the room.
    const Heard& take(const Seen&);
    const SoundPlaces& places() const { return places_; }

  private:
    void breathe(const haptics::TickOutput&);
    void tell(const training::Progress&, double t_s);
    void begin(Sound, const patient::Vec3& stage_m);

    SoundPlaces places_;
    training::Hints hints_;
    double tick_s_;
    Heard heard_;
    std::optional<Seen> last_;
    double breath_v_ = 0.0, breath_s_ = 0.0;  // as the flow was last looked at
    double pulsed_s_ = -1.0;                  // when the tube did so last
    double alarm_s_ = -1.0;                   // began last
};

}  // namespace stylet::trainer
