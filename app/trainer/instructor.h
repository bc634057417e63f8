// What an instructor says while an attempt runs: events that he injects, a pause, a word for the log. Lines
// as on the terminal, wherever they come from.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/training/difficulty.h"
#include "haptics/simulation.h"

namespace stylet::trainer {

// What the next attempt begins with, where it is another than this one's.
struct NextAttempt {
    std::optional<std::uint64_t> seed;    // of a reference patient and the hand
    std::optional<std::string> patient;   // its folder
    std::optional<std::string> scenario;  // a name or a file
    std::optional<training::Difficulty> difficulty;
    bool from_bookmark = false;  // this one again, from its last bookmark
};

// Every line with what it does.
std::string describeInstructorWords();

// Session thread.
class Instructor {
  public:
    // Takes the whole lines that are his out of `typed`, at once and in order; the rest comes back.
    std::string take(std::string_view typed);

    std::vector<haptics::Command> takeCommands() { return std::exchange(commands_, {}); }
    // For the log: "bookmark" or "comment", and the text.
    struct Note {
        std::string kind, text;
    };
    std::vector<Note> takeNotes() { return std::exchange(notes_, {}); }
    // Lines that are his and cannot be done, with the reason.
    std::vector<std::string> takeRefused() { return std::exchange(refused_, {}); }
    bool paused() const { return paused_; }
    // Once each time that he sets another.
    std::optional<training::Difficulty> takeDifficulty() { return std::exchange(difficulty_, {}); }
    // This attempt is to end, and that one to begin; nothing until he says so.
    const std::optional<NextAttempt>& next() const { return next_; }

  private:
    bool takeLine(std::string_view line);
    bool takeNext(std::string_view wish);

    std::string waiting_;  // a line without its end
    std::vector<haptics::Command> commands_;
    std::vector<Note> notes_;
    std::vector<std::string> refused_;
    std::optional<training::Difficulty> difficulty_;
    NextAttempt wished_;  // for the next one, so far
    std::optional<NextAttempt> next_;
    bool paused_ = false;
};

// "cough", "breathing 1.3", ...; empty where the command is not one that he injects.
std::string injectedName(const haptics::Command&);

}  // namespace stylet::trainer
