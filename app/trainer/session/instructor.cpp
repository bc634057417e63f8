#include "app/trainer/session/instructor.h"

#include <array>
#include <charconv>
#include <cstdio>

namespace stylet::trainer {

using haptics::Command;
using haptics::CommandKind;

namespace {

struct InstructorWord {
    std::string_view word, what;
    Command command;
};
constexpr std::array kInstructorWords{
    InstructorWord{"cough", "the patient coughs, which ends a breath-hold", {CommandKind::cough, 0}},
    InstructorWord{"sigh", "the patient sighs", {CommandKind::sigh, 0}},
    InstructorWord{"bleed", "the needle's hole in the skin bleeds", {CommandKind::bleed, 0}},
    InstructorWord{"move", "the patient jerks by 6 mm and returns", {CommandKind::move, 0}},
    InstructorWord{"fault", "simulate a failure of the haptic device", {CommandKind::fault, 0}},
    InstructorWord{"lights out", "the lamps go out", {CommandKind::lights, 0}},
    InstructorWord{"lights on", "the lamps go on again", {CommandKind::lights, 1}},
};
constexpr std::string_view kPause = "pause", kGoOn = "go on", kToggle = "pause or go on",
                           kBookmark = "bookmark", kComment = "comment", kBreathing = "breathing",
                           kDifficulty = "difficulty", kNew = "new", kRetry = "retry";
constexpr const char* kNoDifficulty = "a difficulty is guided, practice or exam";
constexpr std::size_t kLongestInstruction = 512;  // longer incomplete input is passed on

// Returns the text after `word` and blanks, or nothing if the line does not begin with `word`.
std::optional<std::string_view> behind(std::string_view line, std::string_view word) {
    if (!line.starts_with(word)) return std::nullopt;
    line.remove_prefix(word.size());
    if (!line.empty() && line.front() != ' ') return std::nullopt;
    const std::size_t text = line.find_first_not_of(' ');
    return text == std::string_view::npos ? std::string_view{} : line.substr(text);
}

// Parses "1.3" or "1.3 0.8"; the whole text must match.
std::optional<haptics::BreathingScale> scaleIn(std::string_view text) {
    haptics::BreathingScale scale;
    const char *at = text.data(), *const end = at + text.size();
    for (double* value : {&scale.depth, &scale.rate}) {
        const auto [behind_it, error] = std::from_chars(at, end, *value);
        if (error != std::errc() ||
            !(*value >= haptics::kLeastBreathing && *value <= haptics::kMostBreathing))
            return std::nullopt;
        for (at = behind_it; at != end && *at == ' ';)
            ++at;
        if (at == end) return scale;
    }
    return std::nullopt;
}

}  // namespace

std::string describeInstructorWords() {
    std::string text = "Instructor's commands, during any attempt in real time:\n";
    const auto add = [&](std::string_view word, std::string_view what) {
        text += "  " + std::string(word) + std::string(16 - word.size(), ' ') + std::string(what) + "\n";
    };
    for (const InstructorWord& word : kInstructorWords)
        add(word.word, word.what);
    add("breathing D R", "breathe D times as deep and R times as fast from now on (0.5 to 2; R is optional)");
    add("difficulty D", "change the difficulty now: guided, practice or exam");
    add(kPause, "pause the attempt, without force");
    add(kGoOn, "resume the attempt");
    add(kToggle, "pause if running, resume if paused");
    add("bookmark TEXT", "set a bookmark for \"stylet run --from\"; the text is optional");
    add("comment TEXT", "store a comment on the attempt");
    add("new attempt", "store this attempt and begin another; set beforehand:");
    add("new seed N", "  the reference patient and scripted input of this seed");
    add("new patient DIR", "  the patient in this folder");
    add("new scenario S", "  a scenario name or file");
    add("new difficulty D", "  guided, practice or exam");
    add(kRetry, "store this attempt and restart it at its last bookmark");
    return text;
}

std::string Instructor::take(std::string_view typed) {
    waiting_ += typed;
    std::string rest;
    for (std::size_t end; (end = waiting_.find('\n')) != std::string::npos; waiting_.erase(0, end + 1)) {
        std::string_view line(waiting_.data(), end);
        while (!line.empty() && (line.back() == ' ' || line.back() == '\r'))
            line.remove_suffix(1);
        if (!takeLine(line)) rest.append(waiting_, 0, end + 1);
    }
    if (waiting_.size() > kLongestInstruction) rest += std::exchange(waiting_, {});
    return rest;
}

bool Instructor::takeLine(std::string_view line) {
    for (const InstructorWord& word : kInstructorWords)
        if (line == word.word) return commands_.push_back(word.command), true;
    if (line == kPause || line == kGoOn || line == kToggle) {
        const bool pause = line == kToggle ? !paused_ : line == kPause;
        if (pause != paused_) notes_.push_back({"pause", pause ? "paused" : "goes on"});
        paused_ = pause;
        return true;
    }
    if (const auto text = behind(line, kDifficulty)) {
        difficulty_ = training::difficultyNamed(*text);
        if (difficulty_)
            notes_.push_back({"difficulty", std::string(*text)});
        else
            refused_.push_back(kNoDifficulty);
        return true;
    }
    if (line == kRetry) {
        next_.emplace().from_bookmark = true;
        return true;
    }
    if (const auto wish = behind(line, kNew)) return takeNext(*wish);
    if (const auto text = behind(line, kBreathing)) {
        if (const auto scale = scaleIn(*text))
            commands_.push_back(haptics::breathingCommand(*scale));
        else
            refused_.push_back("\"breathing\" needs one number or two from 0.5 to 2");
        return true;
    }
    for (const std::string_view kind : {kBookmark, kComment})
        if (const auto text = behind(line, kind)) {
            notes_.push_back({std::string(kind), std::string(*text)});
            return true;
        }
    return false;
}

// Handles the text after "new".
bool Instructor::takeNext(std::string_view wish) {
    const auto wished = [&](std::string_view what) {
        const auto text = behind(wish, what);
        return text && !text->empty() ? text : std::nullopt;
    };
    if (wish == "attempt") {
        next_ = wished_;
    } else if (const auto seed_text = wished("seed")) {
        std::uint64_t seed = 0;
        const char* const end = seed_text->data() + seed_text->size();
        const auto [stop, error] = std::from_chars(seed_text->data(), end, seed);
        if (error != std::errc() || stop != end)
            refused_.push_back("\"new seed\" needs a whole number");
        else
            wished_.seed = seed, wished_.patient.reset();
    } else if (const auto folder = wished("patient")) {
        wished_.patient = *folder;
    } else if (const auto scenario = wished("scenario")) {
        wished_.scenario = *scenario;
    } else if (const auto name = wished("difficulty")) {
        const auto difficulty = training::difficultyNamed(*name);
        if (difficulty)
            wished_.difficulty = difficulty;
        else
            refused_.push_back(kNoDifficulty);
    } else {
        refused_.push_back("\"new\" needs one of: attempt, seed, patient, scenario, difficulty");
    }
    return true;
}

std::string injectedName(const Command& command) {
    if (command.kind == CommandKind::breathing) {
        const haptics::BreathingScale scale = haptics::breathingScale(command);
        std::array<char, 64> text{};
        std::snprintf(text.data(), text.size(), "breathing %g %g", scale.depth, scale.rate);
        return text.data();
    }
    for (const InstructorWord& word : kInstructorWords)
        if (word.command.kind == command.kind &&
            (command.kind != CommandKind::lights || word.command.value == command.value))
            return std::string(word.word);
    return {};
}

}  // namespace stylet::trainer
