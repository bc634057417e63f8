#include "tests/app/trainer/program/kept_attempt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "app/records/replay.h"
#include "app/training/progress.h"

namespace stylet::test {

namespace fs = std::filesystem;

namespace {

constexpr double kFelt_n = 0.02;

std::string idIn(const Outcome& run, const std::string& trainee) {
    const std::string before = "stored as attempt ";
    const std::size_t at = run.out.find(before);
    std::size_t end = run.out.find(" of " + trainee + "\n");
    for (const char* left_out : {", aborted", ", restarted"})
        if (end == std::string::npos) end = run.out.find(" of " + trainee + left_out);
    if (run.status != 0 || at == std::string::npos || end == std::string::npos)
        throw std::runtime_error("nothing was stored of " + trainee + ":\n" + run.out + run.err);
    return run.out.substr(at + before.size(), end - at - before.size());
}

void replayAgain(Command& command, KeptAttempt& kept) {
    const fs::path folder = kept.stored.folder / "record";
    const Outcome again = command.run("replay --fast '" + folder.string() + "'");
    EXPECT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), kept.summary.at("state_hash"));
    const std::string samples =
        std::to_string(kept.stored.result->ticks) + " stored samples, each as recomputed";
    EXPECT_NE(again.out.find(samples), std::string::npos) << again.out;

    const records::Record record = records::loadRecord(folder);
    const patient::Package package = patient::loadPackage(record.info.patient_folder);
    const patient::Patient patient(package);
    records::replay(
        patient, record,
        [&](const haptics::TickInput& input, const haptics::TickOutput& now, const haptics::NeedleEvents&) {
            for (std::uint32_t i = 0; i < input.command_count; ++i)
                ++kept.commanded[std::size_t(input.commands[i].kind)];
            double& most_n = kept.felt_n[std::size_t(now.tool)];
            most_n = std::max(most_n, glm::length(now.tool_force.force_n));
        });
}

void report(Command& command, KeptAttempt& kept) {
    const fs::path out = command / ("report-" + kept.stored.id);
    const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet-report' attempt " +
                             kept.stored.id + " --records '" + storeOf(command).string() + "' --out '" +
                             out.string() + "' >/dev/null";
    EXPECT_EQ(std::system(line.c_str()), 0) << line;
    kept.page = readText(out / "attempt.html");
    for (const std::string& text : {"Attempt of " + kept.stored.info.trainee, std::string(" of 100")})
        EXPECT_NE(kept.page.find(text), std::string::npos) << text;
    EXPECT_EQ(kept.page.find("What could not be read"), std::string::npos);
    EXPECT_NE(readText(out / "metrics.csv").find("Total,"), std::string::npos);
}

}  // namespace

fs::path storeOf(const Command& command) {
    return command / "data" / "stylet" / "records";
}

fs::path newestAttempt(const Command& command) {
    std::error_code none;
    fs::path newest;  // the largest path is the newest, because an attempt's id starts with its time
    for (const auto& attempt : fs::directory_iterator(storeOf(command) / "attempts", none))
        newest = std::max(newest, attempt.path());
    return newest;
}

int countOf(const fs::path& attempt, const std::string& kind, const std::string& text) {
    const std::vector<records::EventRow> events = records::loadAttemptHead(attempt).info.events;
    return int(std::count_if(events.begin(), events.end(), [&](const records::EventRow& event) {
        return event.kind == kind && event.text == text;
    }));
}

KeptAttempt checkStoredAttempt(Command& command, const Outcome& run, const std::string& trainee) {
    const records::Store store(storeOf(command));
    KeptAttempt kept;
    kept.stored = store.attempt(idIn(run, trainee));
    EXPECT_TRUE(store.damage().empty());
    EXPECT_EQ(kept.stored.info.trainee, trainee);
    EXPECT_EQ(kept.stored.state, records::AttemptState::done);
    if (!kept.stored.result) throw std::runtime_error(kept.stored.id + " has no result");
    kept.summary = nlohmann::json::parse(readText(kept.stored.folder / "summary.json"));
    EXPECT_NEAR(kept.summary.at("score").at("total").get<double>(), kept.stored.result->total, 1e-9);
    replayAgain(command, kept);
    report(command, kept);
    return kept;
}

void expectNothingToRearm(const Outcome& run) {
    for (const char* word :
         {"re-arm", "force off", "force is off", "force paused", "homed", "headset is off"})
        EXPECT_EQ((run.out + run.err).find(word), std::string::npos) << word << "\n" << run.err;
}

void expectWholeProcedure(const KeptAttempt& kept) {
    const nlohmann::json& steps = kept.summary.at("steps");
    EXPECT_EQ(steps.at("done").size(), steps.at("of")) << steps;
    EXPECT_EQ(steps.at("out_of_order"), 0) << steps;
    EXPECT_TRUE(kept.stored.result->target_hit);
    for (std::size_t tool = 0; tool <= std::size_t(haptics::Tool::needle); ++tool)
        EXPECT_GT(kept.felt_n[tool], kFelt_n) << haptics::kToolNames[tool];
    for (const char* text : {"find the duct", "show the ducts with contrast"})
        EXPECT_GT(countOf(kept.stored.folder, "step", text), 0) << text;
}

}  // namespace stylet::test
