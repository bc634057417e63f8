#include "app/trainer/session/instructor.h"

#include <fmt/core.h>
#include <array>
#include <charconv>

#include "app/trainer/stores/console.h"

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
                           kDifficulty = "difficulty", kAbort = "abort", kNew = "new", kRetry = "retry";
constexpr std::pair<std::string_view, std::string_view> kOtherInstructions[]{
    {"breathing D R", "breathe D times as deep and R times as fast from now on (0.5 to 2; R is optional)"},
    {"difficulty D", "change the difficulty now: guided, practice or exam"},
    {kPause, "pause the attempt, without force"},
    {kGoOn, "resume the attempt"},
    {kToggle, "pause if running, resume if paused"},
    {"bookmark TEXT", "set a bookmark for \"stylet run --from\"; the text is optional"},
    {"comment TEXT", "store a comment on the attempt"},
    {kAbort, "end this attempt and mark it as aborted: it enters no statistics"},
    {"new attempt", "store this attempt and begin another; set beforehand:"},
    {"new seed N", "  the reference patient and scripted input of this seed"},
    {"new patient DIR", "  the patient in this folder"},
    {"new scenario S", "  a scenario name or file"},
    {"new difficulty D", "  guided, practice or exam"},
    {kRetry, "store this attempt and restart it at its last bookmark"}};
constexpr const char* kNoDifficulty = "a difficulty is guided, practice or exam";
constexpr std::size_t kMaxInstructionLength = 512;  // longer incomplete input is passed on unparsed

// Returns the text that follows `word` and blanks, or nothing if the line does not begin with `word`.
std::optional<std::string_view> textAfter(std::string_view line, std::string_view word) {
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
            !(*value >= haptics::kMinBreathingScale && *value <= haptics::kMaxBreathingScale))
            return std::nullopt;
        for (at = behind_it; at != end && *at == ' ';)
            ++at;
        if (at == end) return scale;
    }
    return std::nullopt;
}

}  // namespace

std::string describeInstructorCommands() {
    std::string text = "Instructor's commands, during any attempt in real time:\n";
    for (const InstructorWord& word : kInstructorWords)
        text += helpLine(word.word, word.what);
    for (const auto& [word, what] : kOtherInstructions)
        text += helpLine(word, what);
    return text;
}

std::string Instructor::processLines(std::string_view typed) {
    waiting_ += typed;
    std::string rest;
    while (const std::optional<std::string> line = popLine(waiting_))
        if (!parseLine(*line)) rest += *line + '\n';
    if (waiting_.size() > kMaxInstructionLength) rest += std::exchange(waiting_, {});
    return rest;
}

bool Instructor::parseLine(std::string_view line) {
    for (const InstructorWord& word : kInstructorWords)
        if (line == word.word) return commands_.push_back(word.command), true;
    if (line == kPause || line == kGoOn || line == kToggle) {
        const bool pause = line == kToggle ? !paused_ : line == kPause;
        if (pause != paused_) notes_.push_back({"pause", pause ? "paused" : "goes on"});
        paused_ = pause;
        return true;
    }
    if (line == kAbort) return aborted_ = true;
    if (const auto text = textAfter(line, kDifficulty)) {
        difficulty_ = training::difficultyFromName(*text);
        if (difficulty_)
            notes_.push_back({"difficulty", std::string(*text)});
        else
            answers_.push_back(kNoDifficulty);
        return true;
    }
    if (line == kRetry) {
        next_.emplace().from_bookmark = true;
        return true;
    }
    if (const auto wish = textAfter(line, kNew)) return parseNext(*wish);
    if (const auto text = textAfter(line, kBreathing)) {
        if (const auto scale = scaleIn(*text))
            commands_.push_back(haptics::breathingCommand(*scale));
        else
            answers_.push_back("\"breathing\" needs one number or two from 0.5 to 2");
        return true;
    }
    for (const std::string_view kind : {kBookmark, kComment})
        if (const auto text = textAfter(line, kind)) {
            notes_.push_back({std::string(kind), std::string(*text)});
            return true;
        }
    return false;
}

// Handles the text after "new".
bool Instructor::parseNext(std::string_view wish) {
    const auto wished = [&](std::string_view what) {
        const auto text = textAfter(wish, what);
        return text && !text->empty() ? text : std::nullopt;
    };
    const std::size_t refusals = answers_.size();
    if (wish == "attempt") {
        next_ = wished_;
        return true;
    }
    if (const auto seed_text = wished("seed")) {
        if (const auto number = parseNumber<std::uint64_t>(*seed_text))
            wished_.seed = *number, wished_.patient.reset();
        else
            answers_.push_back("\"new seed\" needs a whole number");
    } else if (const auto folder = wished("patient")) {
        wished_.patient = *folder;
    } else if (const auto scenario = wished("scenario")) {
        wished_.scenario = *scenario;
    } else if (const auto name = wished("difficulty")) {
        if (const auto difficulty = training::difficultyFromName(*name))
            wished_.difficulty = difficulty;
        else
            answers_.push_back(kNoDifficulty);
    } else {
        answers_.push_back("\"new\" needs one of: attempt, seed, patient, scenario, difficulty");
    }
    if (answers_.size() == refusals) answers_.push_back(fmt::format("the next attempt has {}", wish));
    return true;
}

std::string injectedName(const Command& command) {
    if (command.kind == CommandKind::breathing) {
        const haptics::BreathingScale scale = haptics::breathingScale(command);
        return fmt::format("breathing {:g} {:g}", scale.depth, scale.rate);
    }
    for (const InstructorWord& word : kInstructorWords)
        if (word.command.kind == command.kind &&
            (command.kind != CommandKind::lights || word.command.value == command.value))
            return std::string(word.word);
    return {};
}

}  // namespace stylet::trainer
