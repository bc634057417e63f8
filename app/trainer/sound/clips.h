// The sounds of the room, made of sines and noise when the program starts: nothing is recorded, nothing is
// shipped. The same samples every time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace stylet::trainer {

// Loops first: they sound for as long as something goes on. The others sound once.
enum class Sound : std::uint8_t {
    room,    // ventilation
    breath,  // the patient's, at his mouth
    buzz,    // the X-ray tube while it pulses
    alarm,   // a structure at risk is struck; again for as long as it is
    beep,    // the patient monitor, once a heartbeat
    click,   // the needle snaps into the guide
    cut,     // the scalpel through skin
    tick,    // a layer gives way to the needle
    chime    // the target is reached
};
inline constexpr int kSoundCount = 9, kLoopCount = 3;
constexpr bool loops(Sound sound) noexcept {
    return int(sound) < kLoopCount;
}
constexpr std::uint32_t bitOf(Sound sound) noexcept {
    return 1u << unsigned(sound);
}

inline constexpr int kClipRate_hz = 48000;
inline constexpr double kClipPeak = 0.95;  // of each clip, of 1

// One channel. The last sample of a loop goes over into its first.
std::vector<float> clipOf(Sound);

}  // namespace stylet::trainer
