// Checks after a whole procedure, with any input: the attempt is stored, replayed and reported.
#pragma once

#include <array>
#include <string>

#include "app/records/store.h"
#include "haptics/haptics.h"
#include "tests/app/trainer/command.h"

namespace stylet::test {

// Attempt store of runs with --trainee and without --records.
std::filesystem::path storeOf(const Command&);
// Folder of the attempt that is running or, if none is, of the last one. Empty if there is none.
std::filesystem::path newestAttempt(const Command&);

// Number of events with this kind and text in the attempt's record, which may still be written.
int countOf(const std::filesystem::path& attempt, const std::string& kind, const std::string& text);

struct KeptAttempt {
    records::StoredAttempt stored;
    nlohmann::json summary;
    std::array<double, haptics::kToolCount> felt_n{};  // largest force per tool
    // Number of commands of each CommandKind.
    std::array<int, std::size_t(haptics::kLastCommandKind) + 1> commanded{};
    std::string page;  // written by stylet-report
};

// Finds the attempt that a run with --trainee reported as stored. Expects that it is done, that its record
// replays to the same state hash and the same samples, and that its report page lists no unreadable data.
// Throws std::runtime_error if there is no such attempt. Every other problem is a test failure.
KeptAttempt checkStoredAttempt(Command&, const Outcome&, const std::string& trainee);

// Expects that nothing printed speaks of a force to lose: the user has a mouse or a controller.
void expectNothingToRearm(const Outcome&);

// Expects all steps in the right order, a force from each tool, and a target hit.
void expectWholeProcedure(const KeptAttempt&);

}  // namespace stylet::test
