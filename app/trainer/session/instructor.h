// Instructor commands during an attempt: injected events, pauses, notes for the log. They are lines of text
// and can come from any source.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/training/difficulty.h"
#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// Settings of the next attempt. Absent settings stay as they are.
struct NextAttempt {
    std::optional<std::uint64_t> seed;    // seed of the reference patient and of the script
    std::optional<std::string> patient;   // folder of the patient
    std::optional<std::string> scenario;  // name or file
    std::optional<training::Difficulty> difficulty;
    bool from_bookmark = false;  // restart this attempt at its last bookmark
};

// Help text: every instructor command.
std::string describeInstructorCommands();

// Session thread.
class Instructor {
  public:
    // Handles all complete lines of `typed` that are instructor commands, at once and in order. Returns the
    // remaining lines.
    std::string processLines(std::string_view typed);

    std::vector<haptics::Command> popCommands() { return std::exchange(commands_, {}); }
    // A note for the log: kind ("bookmark", "comment", "pause", "difficulty") and text.
    struct Note {
        std::string kind, text;
    };
    std::vector<Note> popNotes() { return std::exchange(notes_, {}); }
    // Answers to instructor commands: the reason why one was rejected, or what it sets for the next attempt.
    std::vector<std::string> popAnswers() { return std::exchange(answers_, {}); }
    bool paused() const { return paused_; }
    // The difficulty that was set since the last call, if any.
    std::optional<training::Difficulty> popDifficulty() { return std::exchange(difficulty_, {}); }
    // Set once the instructor has requested the end of this attempt and the next one.
    const std::optional<NextAttempt>& next() const { return next_; }
    // True once the instructor has ended this attempt as aborted: it enters no statistics.
    bool aborted() const { return aborted_; }

  private:
    bool parseLine(std::string_view line);
    bool parseNext(std::string_view wish);

    std::string waiting_;  // incomplete line
    std::vector<haptics::Command> commands_;
    std::vector<Note> notes_;
    std::vector<std::string> answers_;
    std::optional<training::Difficulty> difficulty_;
    NextAttempt wished_;  // settings collected so far for the next attempt
    std::optional<NextAttempt> next_;
    bool paused_ = false, aborted_ = false;
};

// Name of an injected event ("cough", "breathing 1.3 1"); empty for any other command.
std::string injectedName(const haptics::Command&);

}  // namespace stylet::trainer
