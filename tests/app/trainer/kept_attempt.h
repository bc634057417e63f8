// What a whole procedure ends in, however its hand was moved: an attempt that is stored, replayed, reported.
#pragma once

#include <array>
#include <string>

#include "app/records/store.h"
#include "haptics/haptics.h"
#include "tests/app/trainer/command.h"

namespace stylet::test {

// The store of a Command's runs with --trainee and without --records.
std::filesystem::path storeOf(const Command&);
// The folder that the attempt which runs now, or ran last, is kept in; empty while there is none.
std::filesystem::path newestAttempt(const Command&);

// How many of its events are that.
int countOf(const records::StoredAttempt&, const std::string& kind, const std::string& text);

struct KeptAttempt {
    records::StoredAttempt stored;
    nlohmann::json summary;
    std::array<double, haptics::kToolCount> felt_n{};  // the most that was felt of each tool
    // How often, by CommandKind.
    std::array<int, std::size_t(haptics::kLastCommandKind) + 1> commanded{};
    std::string page;  // of stylet-report
};

// The attempt that a run with --trainee said it has stored: done, its record replayed to the same hash and
// its samples to the same bits, its page free of what could not be read. Throws std::runtime_error where
// there is none, and fails the test for all else.
KeptAttempt storedReplayedReported(Command&, const Outcome&, const std::string& trainee);

// Every step of the procedure in its order, each tool felt, and a hit.
void expectWholeProcedure(const KeptAttempt&);

}  // namespace stylet::test
