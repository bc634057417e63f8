// How much help a trainee gets, read from assets/difficulty.toml. It never affects forces or hashes.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "base/text.h"

namespace stylet::training {

// From the most help to the least.
enum class Difficulty : std::uint8_t { guided, practice, exam };
inline constexpr int kDifficultyCount = 3;
inline constexpr std::array<std::string_view, kDifficultyCount> kDifficultyNames{"guided", "practice",
                                                                                 "exam"};

// Where a tool that the mouse moves begins.
enum class StartPlace : std::uint8_t {
    path,  // on the reference path, in front of the skin
    room   // somewhere above the patient, a different place for each seed
};
inline constexpr std::array<std::string_view, 2> kStartPlaceNames{"path", "room"};

// What one difficulty allows. The instructor's mirror is not restricted.
struct DifficultyRules {
    bool panel = false;      // depth, force, tissue, step and score beside the patient
    bool next_step = false;  // what to do next, on the panel
    bool path = false;       // the reference path, in air and in the patient
    bool colours = false;    // red while a risk structure is struck, green when the target is reached
    bool cues = false;       // the same alerts as sounds and controller vibration
    bool slices = false;     // CT slices at the tool's tip
    bool open_look = false;  // looks that show the anatomy beneath the skin
    bool home = false;       // the key that returns the mouse's tool to its start
    bool expert = false;     // the expert's tool doing the current step beside the user's
    bool snap = false;       // mouse and controllers: places the tool on the skin beneath it
    StartPlace start = StartPlace::room;
    // The room is arranged around the planned entry, not around the flank's middle (OperativeField).
    bool showsEntry() const noexcept { return start == StartPlace::path; }
};

// Nothing but what a real room shows.
inline constexpr DifficultyRules kStrictestRules{};

// Until a table is loaded, every difficulty has the strictest rules. Tests of another difficulty load the
// shipped table (tests/app/trainer/difficulties.h).
class DifficultyTable {
  public:
    constexpr DifficultyTable() noexcept { rules_.fill(kStrictestRules); }
    const DifficultyRules& operator[](Difficulty difficulty) const noexcept {
        return rules_[std::size_t(difficulty)];
    }
    DifficultyRules& operator[](Difficulty difficulty) noexcept { return rules_[std::size_t(difficulty)]; }

  private:
    std::array<DifficultyRules, kDifficultyCount> rules_;
};

// Throws DataError with file, field and reason. A difficulty may not allow what an easier one forbids.
DifficultyTable loadDifficulties(const std::filesystem::path& toml);
// The same from the file's text. Errors name `file`.
DifficultyTable parseDifficulties(std::string_view toml, const std::filesystem::path& file);

constexpr std::string_view difficultyName(Difficulty difficulty) noexcept {
    return enumName(kDifficultyNames, difficulty);
}
constexpr std::optional<Difficulty> difficultyFromName(std::string_view name) noexcept {
    return findEnum<Difficulty>(kDifficultyNames, name);
}

}  // namespace stylet::training
