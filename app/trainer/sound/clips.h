// The sounds of the room, synthesised from sines and noise at program start. There are no recordings and no
// files. The samples are the same every time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace stylet::trainer {

// The loops come first; each plays as long as its cause lasts. The others play once.
enum class Sound : std::uint8_t {
    room,    // ventilation
    breath,  // the patient's breath, at the mouth
    buzz,    // X-ray tube while it pulses
    alarm,   // a risk structure is struck; repeated as long as this lasts
    beep,    // patient monitor, once per heartbeat
    click,   // the needle snaps into the guide
    cut,     // the scalpel through skin
    tick,    // the needle punctures a layer
    chime    // target reached
};
inline constexpr int kSoundCount = 9, kLoopCount = 3;
constexpr bool loops(Sound sound) noexcept {
    return int(sound) < kLoopCount;
}
constexpr std::uint32_t soundBit(Sound sound) noexcept {
    return 1u << unsigned(sound);
}

inline constexpr int kClipRate_hz = 48000;
inline constexpr double kClipPeak = 0.95;  // peak of each clip; full scale is 1

// Returns the clip with one channel. The end of a loop joins its beginning without a seam.
std::vector<float> makeClip(Sound);

}  // namespace stylet::trainer
