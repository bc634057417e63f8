#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "app/records/commands.h"
#include "app/records/export.h"
#include "app/records/frames.h"
#include "app/records/record.h"
#include "app/records/schema.h"
#include "tests/app/records/some_result.h"
#include "tests/app/records/some_store.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using std::filesystem::path;
using test::deleteIndex;
using test::readText;
using test::someAttemptInfo;
using test::someResult;
using test::writeUnfinishedRecord;

// HZ-RECORD-04
TEST(Store, RestoresStoredAttempts) {
    const test::TempFolder temp;
    std::string id, second;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        EXPECT_TRUE(std::filesystem::is_directory(store.attemptFolder(id)));
        EXPECT_EQ(store.attempt(id).state, AttemptState::running);
        EXPECT_FALSE(store.attempt(id).result);
        second = store.begin(someAttemptInfo("T-02"));
        test::finish(
            store, id, someResult(),
            {{1, "tool", "finger"}, {700, "cut", "skin"}, {900, "comment", "l\xc3\xa4uft; \"gut\"\n"}});
        test::finish(store, second, {});
    }
    const Store store(temp / "s");
    EXPECT_TRUE(store.recovered().empty());
    ASSERT_EQ(store.attempts().size(), 2u);
    EXPECT_EQ(store.attempts()[0].id, id);
    ASSERT_EQ(store.attempts("T-02").size(), 1u);
    EXPECT_EQ(store.attempts("T-02")[0].id, second);
    const StoredAttempt found = store.attempt(id);
    EXPECT_EQ(found.state, AttemptState::done);
    EXPECT_EQ(found.info.trainee, "T-01");
    EXPECT_EQ(found.info.device, "falcon");
    EXPECT_EQ(found.info.difficulty, "practice");
    EXPECT_EQ(found.info.patient_digest, 0xfedcba9876543210ull);
    EXPECT_EQ(found.info.seed, std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(found.info.device_gain, 0.25);
    EXPECT_EQ(found.info.registration_rms_m, 0.0011);
    EXPECT_EQ(found.started_utc.size(), std::string("2026-11-21T20:15:00.123Z").size());
    ASSERT_EQ(found.events.size(), 3u);
    EXPECT_EQ(found.events[2].tick, 900u);
    EXPECT_EQ(found.events[2].text, "l\xc3\xa4uft; \"gut\"\n");
    ASSERT_TRUE(found.result);
    EXPECT_TRUE(found.result->target_hit);
    EXPECT_EQ(found.result->total, 87.5);
    EXPECT_EQ(found.result->ticks, 12345u);
    ASSERT_EQ(found.result->metrics.size(), 2u);
    EXPECT_TRUE(std::isinf(found.result->metrics[0].value));
    EXPECT_TRUE(std::isnan(found.result->metrics[1].value));
    EXPECT_EQ(found.result->metrics[1].max_points, 8.0);
    EXPECT_FALSE(std::filesystem::exists(found.folder / ".writing")) << "no trace of the writer's lock";
}

TEST(Store, AbandonedAttemptIsRemoved) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string id = store.begin(someAttemptInfo());
    writeUnfinishedRecord(store.attempt(id), 1);
    store.abandon(id);
    EXPECT_TRUE(store.attempts().empty());
    EXPECT_TRUE(store.outbox().empty());
    EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(id)));
    EXPECT_NE(test::errorText([&] { store.finish(id); }).find("not being written"), std::string::npos);
}

AttemptResult abortedResult() {
    AttemptResult result = someResult();
    result.aborted = true;
    return result;
}

TEST(Store, AnAbortedAttemptIsListedAndDoesNotCount) {
    const test::TempFolder temp;
    std::string aborted, done;
    {
        Store store(temp / "s");
        aborted = store.begin(someAttemptInfo());
        test::finish(store, aborted, abortedResult());
        done = store.begin(someAttemptInfo());
        test::finish(store, done);
    }
    for (const bool lost_index : {false, true}) {
        if (lost_index) deleteIndex(temp / "s");
        const Store store(temp / "s");
        ASSERT_EQ(store.attempts().size(), 2u);
        EXPECT_FALSE(countsInStatistics(store.attempt(aborted)));
        EXPECT_EQ(stateText(store.attempt(aborted)), "aborted");
        EXPECT_EQ(store.attempt(aborted).state, AttemptState::done);
        EXPECT_TRUE(countsInStatistics(store.attempt(done)));
        EXPECT_EQ(stateText(store.attempt(done)), "done");
        EXPECT_EQ(store.attempt(done).result->score_version, 3u);
        EXPECT_TRUE(store.damage().empty());
    }
    // The checksum covers the mark.
    SQLite::Database(temp / "s" / "store.sqlite", SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET aborted = 1 - aborted, score_version = score_version + 1");
    EXPECT_EQ(Store(temp / "s").damage().size(), 2u);
}

// Its ticks up to the bookmark are another attempt's, perhaps another person's.
TEST(Store, ARestartedAttemptIsListedAndDoesNotCount) {
    const test::TempFolder temp;
    std::string restarted;
    {
        Store store(temp / "s");
        restarted = store.begin(someAttemptInfo());
        test::finish(store, restarted, someResult(), {{0, "retry", "attempt-of-an-expert until bookmark 2"}});
    }
    for (const bool lost_index : {false, true}) {
        if (lost_index) deleteIndex(temp / "s");
        const Store store(temp / "s");
        const StoredAttempt attempt = store.attempt(restarted);
        EXPECT_TRUE(isRestarted(attempt));
        EXPECT_FALSE(countsInStatistics(attempt));
        EXPECT_EQ(stateText(attempt), "restarted");
        EXPECT_EQ(attempt.events.at(0).text, "attempt-of-an-expert until bookmark 2");
    }
    Store store(temp / "s");
    store.discard(restarted);
    EXPECT_NE(store.log().back().text.find(restarted + ": restarted"), std::string::npos);
}

// Killing the program must not hide a failing exam.
TEST(Store, AnExamThatWasCutShortAfterADecisiveEventIsNotPassed) {
    const std::vector<EventRow> idle{{1, "tool", "finger"}, {9, "contact", "finger on the skin"}};
    struct Case {
        const char* difficulty;
        EventRow last;
        bool counts;
    };
    for (const Case& c :
         {Case{"exam", {20, "critical", "the lung was punctured"}, true},
          Case{"exam", {20, "cut", "skin at 0.1 mm"}, true}, Case{"exam", {20, "answer", "wrong"}, true},
          Case{"exam", {20, "contact", "needle on the skin"}, true},
          Case{"exam", {20, "breath", "held"}, false},
          Case{"practice", {20, "critical", "the lung was punctured"}, false}}) {
        const test::TempFolder temp;
        std::string id;
        {
            Store store(temp / "s");
            AttemptInfo info = someAttemptInfo();
            info.difficulty = c.difficulty;
            id = store.begin(info);
            std::vector<EventRow> events = idle;
            events.push_back(c.last);
            writeUnfinishedRecord(store.attempt(id), 300, events);
        }
        Store store(temp / "s");
        const StoredAttempt attempt = store.attempt(id);
        EXPECT_EQ(isUnfinishedExam(attempt), c.counts) << c.difficulty << ' ' << c.last.kind;
        EXPECT_EQ(stateText(attempt), c.counts ? "cut short, not passed" : "cut short");
        EXPECT_FALSE(countsInStatistics(attempt)) << "it has no score";
        if (std::string(c.difficulty) == "exam") {
            EXPECT_NE(test::errorText([&] { store.discard(id); }).find("it is kept"), std::string::npos);
        }
    }
}

// The instructor has made the exam easier, so it is none.
TEST(Store, AnExamMadeEasierMayBeCutShort) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        AttemptInfo info = someAttemptInfo();
        info.difficulty = "exam";
        id = store.begin(info);
        writeUnfinishedRecord(store.attempt(id), 300,
                              {{5, "difficulty", "practice"}, {20, "critical", "the lung was punctured"}});
    }
    EXPECT_EQ(stateText(Store(temp / "s").attempt(id)), "cut short");
}

// A record may come from elsewhere. Its texts must not control the terminal.
// HZ-RECORD-07
TEST(Store, PrintsNoControlCharacters) {
    const test::TempFolder temp;
    Store store(temp / "s");
    AttemptInfo info = someAttemptInfo();
    info.scenario = "a\nb\x1b]0;title\x07", info.patient =
                                                "\xC2\x9B"
                                                "31m";
    const std::string id = store.begin(info);
    test::finish(store, id, someResult(), {{1, "comment", "\x1b[2J"}});
    testing::internal::CaptureStdout();
    EXPECT_EQ(listAttempts({temp / "s", "", "", "", ""}), 0);
    EXPECT_EQ(showAttempt({temp / "s", "", id, "", ""}), 0);
    const std::string shown = testing::internal::GetCapturedStdout();
    EXPECT_EQ(shown.find_first_of("\x1b\x07\x9b"), shown.npos) << shown;
    EXPECT_NE(shown.find("  a?b?]0;title?"), shown.npos) << shown;
    EXPECT_NE(shown.find("comment    ?[2J\n"), shown.npos) << shown;
}

TEST(Store, ListsAndShowsNoNumberThatThereIsNot) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id);  // with a metric of NaN and an infinite one
    }
    testing::internal::CaptureStdout();
    EXPECT_EQ(showAttempt({temp / "s", "", id, "", ""}), 0);
    const std::string shown = testing::internal::GetCapturedStdout();
    EXPECT_NE(shown.find(" – mm "), std::string::npos) << shown;
    EXPECT_NE(shown.find(" – deg "), std::string::npos) << shown;
    EXPECT_EQ(shown.find("nan"), std::string::npos) << shown;
    EXPECT_EQ(shown.find("inf"), std::string::npos) << shown;
}

// HZ-RECORD-07
TEST(Store, RowsThatDifferFromTheirRecordsAreNamed) {
    const test::TempFolder temp;
    std::string forged, honest, unreadable;
    {
        Store store(temp / "s");
        forged = store.begin(someAttemptInfo());
        test::finish(store, forged, someResult(), {{5, "critical", "the lung was punctured"}});
        honest = store.begin(someAttemptInfo());
        test::finish(store, honest, someResult(), {{5, "comment", "well done"}});
        EXPECT_TRUE(findAlteredRows(store.attempts()).empty());
    }
    const auto edit = [&](const std::string& sql) {
        SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE).exec(sql);
        return findAlteredRows(Store(temp / "s").attempts());
    };
    const std::string mine = " WHERE id = '" + forged + "'";
    std::vector<std::string> lines = edit("UPDATE attempt SET total = 99.9" + mine);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0], "attempt " + forged +
                            ": the index or the record was altered: score 99.9 is 87.5 in its record");
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    EXPECT_EQ(listAttempts({temp / "s", "", "", "", ""}), 0);
    testing::internal::GetCapturedStdout();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "stylet: " + lines[0] + "\n");
    edit("UPDATE attempt SET total = 87.5" + mine);
    lines = edit("DELETE FROM event WHERE kind = 'critical'");
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find(forged + ": the index or the record was altered: number of events 0 is 1"),
              std::string::npos)
        << lines[0];
    std::filesystem::remove(temp / "s" / "attempts" / honest / "record" / "record.json");
    lines = edit("UPDATE attempt SET trainee = 'T-02'" + mine);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_NE(lines[0].find("trainee T-02 is T-01 in its record"), std::string::npos) << lines[0];
    EXPECT_TRUE(lines[1].starts_with("1 attempt was not compared with its record: ")) << lines[1];
}

TEST(Store, DiscardsOnlyWhatDoesNotCountAndLogsIt) {
    const test::TempFolder temp;
    std::string aborted, cut_short, done;
    {
        Store store(temp / "s");
        aborted = store.begin(someAttemptInfo("T-discards"));
        EXPECT_NE(test::errorText([&] { store.discard(aborted); }).find("is being written"),
                  std::string::npos);
        test::finish(store, aborted, abortedResult());
        done = store.begin(someAttemptInfo());
        test::finish(store, done);
        cut_short = store.begin(someAttemptInfo());
        writeUnfinishedRecord(store.attempt(cut_short), 300);
    }
    Store store(temp / "s");
    EXPECT_TRUE(store.log().empty());
    EXPECT_NE(test::errorText([&] { store.discard(done); }).find("cannot be discarded"), std::string::npos);
    EXPECT_NE(test::errorText([&] { store.discard("no-such-id"); }).find("there is none"), std::string::npos);
    EXPECT_NE(test::errorText([&] { store.discard("../" + done); }), "");
    EXPECT_EQ(store.attempts().size(), 3u);
    EXPECT_TRUE(store.log().empty()) << "a refused discard is none";

    store.discard(aborted);
    store.discard(cut_short);
    ASSERT_EQ(store.attempts().size(), 1u);
    EXPECT_EQ(store.attempts()[0].id, done);
    EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(aborted)));
    const std::vector<LogEntry> log = store.log();
    ASSERT_EQ(log.size(), 2u);
    EXPECT_NE(log[0].text.find(aborted + ": aborted"), std::string::npos) << log[0].text;
    EXPECT_NE(log[1].text.find(cut_short + ": cut short"), std::string::npos) << log[1].text;
    EXPECT_EQ(log[0].text.find("T-discards"), std::string::npos) << "a deleted trainee leaves no name";
    EXPECT_EQ(log[0].utc.size(), 24u);
    EXPECT_NE(test::errorText([&] { store.discard(aborted); }).find("there is none"), std::string::npos);
    std::size_t erased = 0;
    for (const OutboxEntry& entry : store.outbox()) {
        erased += entry.kind == OutboxEntry::Kind::erase;
        EXPECT_TRUE(entry.kind == OutboxEntry::Kind::erase || entry.attempt_id == done);
    }
    EXPECT_EQ(erased, 2u);
    EXPECT_TRUE(store.damage().empty());
}

// HZ-RECORD-07
TEST(Store, FinishNeedsTheRecordOfThisAttemptWithItsResult) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string id = store.begin(someAttemptInfo());
    const auto refused = [&](const std::string& field) {
        test::expectRefused([&] { store.finish(id); }, "record.json", field);
        EXPECT_EQ(store.attempt(id).state, AttemptState::running);
    };
    refused("file");  // there is none
    writeUnfinishedRecord(store.attempt(id), 10);
    refused("result");
    StoredAttempt other = store.attempt(id);
    other.id = "another";
    test::beginRecord(other).finish(someResult());
    refused("id");
    other = store.attempt(id);
    other.info.trainee = "..";
    test::beginRecord(other).finish(someResult());
    refused("trainee");
    std::ofstream(store.attemptFolder(id) / "record" / "record.json") << R"({"format_version": 8})";
    refused("format_version: 8 is not " + std::to_string(kRecordVersion) +
            ": the record was written by an older program version");
    test::finish(store, id);
    EXPECT_EQ(store.attempt(id).state, AttemptState::done);
}

// HZ-RECORD-06
TEST(Store, OpensEveryOlderSchema) {
    for (std::size_t version = 1; version <= schemaSteps().size(); ++version) {
        const test::TempFolder temp;
        std::filesystem::create_directories(temp / "s");
        {
            SQLite::Database old((temp / "s" / "store.sqlite").string(),
                                 SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
            old.exec(schemaSteps()[0]);
            old.exec(
                "INSERT INTO attempt VALUES (7, 'an-id', 'T-9', '2026-01-02T03:04:05.678Z', 'done', "
                "'falcon', "
                "'someone', '00000000000000ff', 'demo', 'exam', '0.1', '18446744073709551615', 0.001, 1.0, "
                "NULL, 1, 61.25, 4000);"
                "INSERT INTO metric VALUES (7, 0, 'm', 'a metric', 'mm', 1.5, 2.5, 3.5);"
                "INSERT INTO event VALUES (7, 0, 12, 'cut', 'duct')");
            for (const char* step : schemaSteps().subspan(1, version - 1))
                old.exec(step);
            std::filesystem::create_directories(temp / "s" / "attempts" / "an-id");
            std::ofstream(temp / "s" / "attempts" / "an-id" / "summary.json") << "{}";
            old.exec("PRAGMA application_id = " + std::to_string(kStoreId));
            old.exec("PRAGMA user_version = " + std::to_string(version));
        }
        Store store(temp / "s");
        const StoredAttempt old = store.attempt("an-id");
        EXPECT_EQ(old.info.patient_digest, 255u) << version;
        EXPECT_EQ(old.result.value().total, 61.25);
        EXPECT_EQ(old.result.value().metrics.at(0).points, 2.5);
        EXPECT_EQ(old.events.at(0).text, "duct");
        if (version == 1) {
            EXPECT_EQ(store.files("an-id").size(), 1u) << "so that the centre gets it";
        }
        const std::string id = store.begin(someAttemptInfo());
        test::finish(store, id, someResult());
        EXPECT_EQ(store.attempts().size(), 2u);
        EXPECT_EQ(store.outbox().size(), 2u) << "the centre hears of what was there before it had one";
        EXPECT_TRUE(store.damage().empty());
    }
}

// HZ-RECORD-07
TEST(Store, ReportsFlippedBytes) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string id = store.begin(someAttemptInfo());
    std::ofstream(store.attemptFolder(id) / "summary.json") << "{}";
    test::finish(store, id, someResult(), {{5, "comment", "well done"}}, 3 * kFrameTicks);
    ASSERT_EQ(store.files(id).size(), 3u);
    EXPECT_EQ(store.files(id)[1].file, "record/record.json");
    EXPECT_TRUE(store.damage().empty());

    const path inputs = store.attemptFolder(id) / "record" / "inputs.bin";
    std::string bytes = readText(inputs);
    const auto half = bytes.size() / 2;
    bytes[half] ^= 1;
    std::ofstream(inputs, std::ios::binary) << bytes;
    std::filesystem::remove(store.attemptFolder(id) / "summary.json");
    std::ofstream(store.attemptFolder(id) / "record" / "record.json", std::ios::app) << " ";
    SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("UPDATE event SET text = 'well dona'");
    EXPECT_NE(test::errorText([&] { store.checkRecord(id); }).find("record.json: has "), std::string::npos);
    std::vector<std::string> damage = store.damage();
    ASSERT_EQ(damage.size(), 4u);
    EXPECT_NE(damage[0].find("inputs.bin: its checksum does not match; whole for 250 ticks"),
              std::string::npos);
    EXPECT_NE(damage[1].find("record.json: has "), std::string::npos);
    EXPECT_NE(damage[2].find("summary.json: is gone"), std::string::npos);
    EXPECT_NE(damage[3].find("store.sqlite: the checksum of attempt " + id), std::string::npos);

    std::filesystem::create_directory(store.attemptFolder(id) / "summary.json");
    damage = store.damage();
    ASSERT_EQ(damage.size(), 4u) << "what cannot be read hides nothing else";
    EXPECT_NE(damage[2].find("summary.json: cannot be checked"), std::string::npos);
}

// HZ-RECORD-11
TEST(Export, FormulaTextsAreEscaped) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string id = store.begin(someAttemptInfo());
    AttemptResult result = someResult();
    result.metrics[0].value = -std::numeric_limits<double>::infinity();
    test::finish(store, id, result,
                 {{1, "comment", "=HYPERLINK(\"x\")"}, {2, "comment", "-1+1"}, {3, "comment", "-1.5"}});
    exportAttempts(store, "", temp / "taken");
    const std::string events = readText(temp / "taken" / "events.csv");
    EXPECT_NE(events.find(",\"'=HYPERLINK(\"\"x\"\")\"\r\n"), std::string::npos) << events;
    EXPECT_NE(events.find(",'-1+1\r\n"), std::string::npos) << events;
    EXPECT_NE(events.find(",-1.5\r\n"), std::string::npos) << events;
    EXPECT_NE(readText(temp / "taken" / "metrics.csv").find(",-inf,"), std::string::npos)
        << "a number stays one";
}

TEST(Store, QueuesAttemptsAndDeletionsForTheCentre) {
    const test::TempFolder temp;
    std::string done, cut;
    {
        Store store(temp / "s");
        done = store.begin(someAttemptInfo());
        EXPECT_TRUE(store.outbox().empty()) << "nothing of an attempt that still runs";
        test::finish(store, done, someResult());
        cut = store.begin(someAttemptInfo());
    }
    Store store(temp / "s");
    std::vector<OutboxEntry> entries = store.outbox();
    ASSERT_EQ(entries.size(), 2u);
    EXPECT_EQ(entries[0].attempt_id, done);
    EXPECT_EQ(entries[1].attempt_id, cut);
    store.markFailed(entries[0], "no route");
    store.markFailed(entries[0], "no way");
    EXPECT_EQ(store.outbox()[0].tries, 2u);
    EXPECT_EQ(store.outbox()[0].error, "no way");
    store.markSent(entries[0]);
    ASSERT_EQ(store.outbox().size(), 1u);
    store.eraseTrainee("T-01");
    entries = store.outbox();
    ASSERT_EQ(entries.size(), 2u) << "never told of the second, which may be on its way";
    EXPECT_EQ(entries[0].kind, OutboxEntry::Kind::erase);
    EXPECT_EQ(entries[0].attempt_id, done);
    EXPECT_EQ(entries[1].attempt_id, cut);
}

// HZ-RECORD-06
TEST(Store, RefusesOtherDatabasesAndNewerSchemas) {
    const test::TempFolder temp;
    for (const char* name : {"text", "other", "newer"})
        std::filesystem::create_directories(temp / name);
    std::ofstream(temp / "text" / "store.sqlite") << std::string(5000, 'x');
    SQLite::Database((temp / "other" / "store.sqlite").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("CREATE TABLE song (name TEXT)");
    {
        Store(temp / "newer");
    }
    SQLite::Database((temp / "newer" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("PRAGMA user_version = 999");
    {
        Store(temp / "odd");
    }
    SQLite::Database((temp / "odd" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("PRAGMA user_version = -1");
    EXPECT_NE(test::errorText([&] { Store(temp / "odd"); }).find("below 0"), std::string::npos);
    EXPECT_NE(test::errorText([&] { Store(temp / "text"); }).find("database"), std::string::npos);
    const std::string others = readText(temp / "other" / "store.sqlite");
    EXPECT_NE(test::errorText([&] { Store(temp / "other"); }).find("not a Stylet store"), std::string::npos);
    EXPECT_EQ(readText(temp / "other" / "store.sqlite"), others) << "untouched";
    EXPECT_NE(test::errorText([&] { Store(temp / "newer"); }).find("999 is newer"), std::string::npos);
    EXPECT_NE(test::errorText([&] { Store("/proc/nothing"); }), "");
    EXPECT_NE(test::errorText([&] { Store(temp / "fresh").attempt("nobody"); }).find("there is none"),
              std::string::npos);
}

// HZ-RECORD-05
TEST(Store, ClockSetBackDoesNotChangeTheOrder) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string first = store.begin(someAttemptInfo());
    test::finish(store, first, someResult());
    // Simulates a clock that had been set to the year 2999.
    SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET started_utc = '2999-01-01T00:00:00.000Z'");
    std::vector<std::string> ids{first};
    for (int i = 0; i < 20; ++i) {  // also within one second
        ids.push_back(store.begin(someAttemptInfo()));
        test::finish(store, ids.back(), someResult());
    }
    std::vector<std::string> listed;
    for (const StoredAttempt& attempt : store.attempts("T-01"))
        listed.push_back(attempt.id);
    EXPECT_EQ(listed, ids);
}

}  // namespace
}  // namespace stylet::records
