// How much a trainee is helped. Decides what is shown and said, never what is felt or hashed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace stylet::training {

enum class Difficulty : std::uint8_t { guided, practice, exam };
inline constexpr std::array<std::string_view, 3> kDifficultyNames{"guided", "practice", "exam"};

// In an exam there is nothing but what a real room has: its machines and their sounds.
struct Hints {
    bool cues = false;  // by sound and pulse: a structure at risk is struck, the target is reached
};
constexpr Hints hintsOf(Difficulty difficulty) noexcept {
    return {difficulty != Difficulty::exam};
}

constexpr std::optional<Difficulty> difficultyNamed(std::string_view name) noexcept {
    for (std::size_t i = 0; i < kDifficultyNames.size(); ++i)
        if (kDifficultyNames[i] == name) return Difficulty(i);
    return std::nullopt;
}

}  // namespace stylet::training
