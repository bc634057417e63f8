// How much help a trainee gets. It affects what is shown and played as sound, never forces or hashes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/text.h"

namespace stylet::training {

enum class Difficulty : std::uint8_t { guided, practice, exam };
inline constexpr std::array<std::string_view, 3> kDifficultyNames{"guided", "practice", "exam"};

// An exam shows only what a real room has: the equipment and its sounds.
struct Hints {
    bool panel = false;      // depth, force, tissue, step and score beside the patient
    bool next_step = false;  // what to do next, on the panel
    bool ghost = false;      // the reference path, in air and in the patient
    bool colours = false;    // red while a risk structure is struck, green when the target is reached
    bool cues = false;       // the same alerts as sounds and controller vibration
};
constexpr Hints makeHints(Difficulty difficulty) noexcept {
    if (difficulty == Difficulty::exam) return {};
    const bool guided = difficulty == Difficulty::guided;
    return {true, guided, guided, true, true};
}

constexpr std::string_view difficultyName(Difficulty difficulty) noexcept {
    return enumName(kDifficultyNames, difficulty);
}
constexpr std::optional<Difficulty> difficultyFromName(std::string_view name) noexcept {
    return findEnum<Difficulty>(kDifficultyNames, name);
}

}  // namespace stylet::training
