// Stores after a crash: attempts that were cut short, lost indices, damaged and unknown folders.
#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "app/records/attempt_files.h"
#include "app/records/commands.h"
#include "app/records/frames.h"
#include "app/records/record.h"
#include "tests/app/records/privacy.h"
#include "tests/app/records/some_result.h"
#include "tests/app/records/some_store.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using std::filesystem::path;
using test::contains;
using test::deleteIndex;
using test::readText;
using test::someAttemptInfo;
using test::someResult;
using test::writeUnfinishedRecord;

// HZ-RECORD-01
TEST(Store, RecoversAttemptsOfAKilledWriter) {
    const test::TempFolder temp;
    std::string torn, early;
    {
        Store store(temp / "s");
        torn = store.begin(someAttemptInfo());
        writeUnfinishedRecord(store.attempt(torn), 3 * kFrameTicks, {{5, "tool", "probe"}});
        std::ofstream(store.attemptFolder(torn) / "record" / "inputs.bin", std::ios::app)
            << "FRAM half a frame";
        early = store.begin(someAttemptInfo());
    }
    const Store store(temp / "s");
    ASSERT_EQ(store.recovered().size(), 2u);
    EXPECT_EQ(describe(store.recovered()[0]),
              "attempt " + torn + " was cut short: record/inputs.bin keeps 750 ticks, 17 torn bytes cut off");
    EXPECT_EQ(describe(store.recovered()[1]),
              "attempt " + early + " was cut short: nothing was recorded yet");
    EXPECT_EQ(store.attempt(torn).state, AttemptState::cut_short);
    EXPECT_EQ(store.attempt(torn).events.size(), 1u);
    const Record record = loadRecord(store.attemptFolder(torn) / "record");
    EXPECT_EQ(record.inputs.size(), 3 * kFrameTicks);
    EXPECT_EQ(record.torn_bytes, 0u);
    EXPECT_TRUE(Store(temp / "s").recovered().empty()) << "only once";
}

// HZ-RECORD-03
TEST(Store, AnAttemptBeingWrittenIsNotRecovered) {
    const test::TempFolder temp;
    Store writer(temp / "s");
    const std::string id = writer.begin(someAttemptInfo());
    Store other(temp / "s");
    EXPECT_TRUE(other.recovered().empty());
    EXPECT_NE(test::errorText([&] { other.finish(id); }).find("not being written here"), std::string::npos);
    EXPECT_NE(test::errorText([&] { other.eraseTrainee("T-01"); }).find("is being written"),
              std::string::npos);
    test::finish(writer, id, someResult());
    EXPECT_EQ(other.attempt(id).state, AttemptState::done);
    EXPECT_NE(test::errorText([&] { writer.finish(id); }), "") << "once";
}

TEST(Store, UnrecoverableAttemptDoesNotBlockOthers) {
    const test::TempFolder temp;
    std::string bad, good;
    {
        Store store(temp / "s");
        bad = store.begin(someAttemptInfo());
        good = store.begin(someAttemptInfo("T-02"));
        createPrivateFolders(store.attemptFolder(bad) / "record" / "inputs.bin");  // a folder
    }
    Store store(temp / "s");
    ASSERT_EQ(store.recovered().size(), 1u);
    EXPECT_EQ(store.recovered()[0].id, good);
    ASSERT_EQ(store.openingMessages().size(), 2u);
    EXPECT_NE(store.openingMessages()[1].find(bad + " was cut short and cannot be recovered"),
              std::string::npos);
    EXPECT_EQ(store.attempt(bad).state, AttemptState::running);
    EXPECT_EQ(store.eraseTrainee("T-01"), 1u);
    EXPECT_EQ(store.attempts().size(), 1u);
}

// The index repeats what the records say, so a lost one is filled again.
// HZ-RECORD-01
TEST(Store, ALostIndexIsFilledFromTheRecords) {
    const test::TempFolder temp;
    std::string done, cut, old;
    StoredAttempt before;
    {
        Store store(temp / "s");
        done = store.begin(someAttemptInfo());
        test::finish(store, done, someResult(), {{1, "tool", "finger"}}, 300);
        cut = store.begin(someAttemptInfo("T-02"));
        writeUnfinishedRecord(store.attempt(cut), 300, {{2, "tool", "probe"}});
        old = store.begin(someAttemptInfo("T-03"));
        writeUnfinishedRecord(store.attempt(old), 10);
        std::ofstream(store.attemptFolder(old) / "record" / "record.json") << R"({"format_version": 8})";
        before = store.attempt(done);
    }
    std::filesystem::copy(temp / "s" / "attempts" / done, temp / "s" / "attempts" / "renamed",
                          std::filesystem::copy_options::recursive);
    deleteIndex(temp / "s");
    const Store store(temp / "s");
    ASSERT_EQ(store.attempts().size(), 2u);
    const StoredAttempt again = store.attempt(done);
    EXPECT_EQ(again.state, AttemptState::done);
    EXPECT_EQ(again.started_utc, before.started_utc);
    EXPECT_EQ(again.info.trainee, "T-01");
    EXPECT_EQ(again.info.patient_digest, before.info.patient_digest);
    EXPECT_EQ(again.info.registration_rms_m, before.info.registration_rms_m);
    EXPECT_EQ(again.events.at(0).text, "finger");
    EXPECT_TRUE(std::isinf(again.result.value().metrics.at(0).value));
    EXPECT_TRUE(std::isnan(again.result.value().metrics.at(1).value));
    EXPECT_TRUE(countsInStatistics(again));
    EXPECT_TRUE(contains(store.openingMessages(),
                         "the index was lost and is filled again from the records of 2 attempts"));
    EXPECT_EQ(store.attempt(cut).state, AttemptState::cut_short);
    EXPECT_EQ(store.attempt(cut).events.at(0).text, "probe");
    EXPECT_EQ(store.unknownFolders().size(), 2u) << "a record of another id, and one that cannot be read";
    EXPECT_TRUE(store.damage().empty());
}

// A disk that fails for a moment must not make an attempt look imported.
TEST(Store, ALostIndexIsFilledAgainInSeveralOpenings) {
    const test::TempFolder temp;
    std::vector<std::string> ids;
    {
        Store store(temp / "s");
        for (const char* trainee : {"T-01", "T-02"}) {
            ids.push_back(store.begin(someAttemptInfo(trainee)));
            test::finish(store, ids.back(), someResult());
        }
    }
    const path record = temp / "s" / "attempts" / ids[1] / "record" / "record.json", aside = temp / "aside";
    std::filesystem::rename(record, aside);
    std::ofstream(record) << "{";
    deleteIndex(temp / "s");
    EXPECT_EQ(Store(temp / "s").attempts().size(), 1u);
    std::filesystem::rename(aside, record);
    const Store store(temp / "s");
    for (const std::string& id : ids)
        EXPECT_TRUE(countsInStatistics(store.attempt(id))) << id;
    ASSERT_EQ(store.log().size(), 2u);
    EXPECT_NE(store.log()[0].text.find("the index was lost"), std::string::npos);
}

// A trainee marks a failing exam as imported while it runs, so that it enters no statistics.
// HZ-RECORD-07
TEST(Store, AnAttemptOfThisStoreCannotBeMarkedAsImported) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string id = store.begin(someAttemptInfo());
    std::ofstream(store.attemptFolder(id) / kImportedMark) << "x";
    test::finish(store, id, someResult());
    EXPECT_TRUE(countsInStatistics(store.attempt(id)));
    EXPECT_EQ(findAlteredRows(store.attempts()).size(), 1u);
}

// Somebody copies a passed attempt, and gives the copy another id, trainee, difficulty and device.
// HZ-RECORD-07
TEST(Store, ACopiedFolderIsImportedAndEntersNoStatistics) {
    const test::TempFolder temp;
    std::string original, copy;
    {
        Store store(temp / "s");
        original = store.begin(someAttemptInfo());
        test::finish(store, original, someResult());
        StoredAttempt forged = store.attempt(original);
        forged.id = copy = "20260101T000000Z-12345678";
        forged.info.trainee = "T-99", forged.info.difficulty = "exam", forged.info.device = "mouse";
        forged.folder = store.attemptFolder(copy);
        test::beginRecord(forged).finish(someResult());
    }
    {
        const Store store(temp / "s");
        ASSERT_EQ(store.openingMessages().size(), 1u);
        EXPECT_NE(store.openingMessages()[0].find("attempt " + copy + " was not recorded by this store"),
                  std::string::npos)
            << store.openingMessages()[0];
    }
    const Store store(temp / "s");
    EXPECT_TRUE(store.openingMessages().empty()) << "once";
    EXPECT_TRUE(store.attempt(copy).imported);
    EXPECT_EQ(stateText(store.attempt(copy)), "imported");
    EXPECT_FALSE(countsInStatistics(store.attempt(copy)));
    EXPECT_FALSE(store.attempt(original).imported);
    EXPECT_TRUE(countsInStatistics(store.attempt(original)));
    EXPECT_TRUE(store.damage().empty());
    EXPECT_NE(test::errorText([&] { Store(temp / "s").discard(copy); }).find("it is kept"),
              std::string::npos);
    testing::internal::CaptureStdout();
    EXPECT_EQ(recoverStore({temp / "s", "", "", "", ""}), 0);
    EXPECT_NE(testing::internal::GetCapturedStdout().find("imported, not recorded by this store: " + copy),
              std::string::npos);
    SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET imported = 0");
    EXPECT_EQ(Store(temp / "s").damage().size(), 1u) << "the checksum covers the mark";
    const std::vector<std::string> altered = findAlteredRows(Store(temp / "s").attempts());
    ASSERT_EQ(altered.size(), 1u);
    EXPECT_EQ(altered[0], "attempt " + copy +
                              ": the index or the record was altered: listed as recorded by this store, its "
                              "folder is marked as imported");
}

// The mark is in the folder too, so neither a lost index nor an index edited to be filled again removes it.
// HZ-RECORD-07
TEST(Store, AnImportedAttemptStaysImported) {
    const test::TempFolder temp;
    const std::string copy = "20260101T000000Z-12345678";
    const auto edit = [&](const char* sql) {
        SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE).exec(sql);
    };
    {
        Store store(temp / "s");
        const std::string original = store.begin(someAttemptInfo());
        test::finish(store, original, someResult());
        StoredAttempt copied = store.attempt(original);
        copied.id = copy, copied.folder = store.attemptFolder(copy);
        test::beginRecord(copied).finish(someResult());
    }
    EXPECT_TRUE(Store(temp / "s").attempt(copy).imported);
    edit("UPDATE attempt SET imported = 0, state = 'running'");
    EXPECT_TRUE(Store(temp / "s").attempt(copy).imported);
    deleteIndex(temp / "s");
    EXPECT_TRUE(Store(temp / "s").attempt(copy).imported);
    EXPECT_TRUE(Store(temp / "s").damage().empty());
    // A store of schema 4 has the mark in the row only.
    std::filesystem::remove(temp / "s" / "attempts" / copy / "imported.txt");
    edit("DELETE FROM file WHERE path = 'imported.txt'; PRAGMA user_version = 4");
    const Store store(temp / "s");
    EXPECT_TRUE(findAlteredRows(store.attempts()).empty());
    EXPECT_EQ(store.files(copy).size(), 3u);
    EXPECT_TRUE(store.damage().empty());
    edit("UPDATE attempt SET imported = 1");
    const std::vector<std::string> altered = findAlteredRows(store.attempts());
    ASSERT_EQ(altered.size(), 1u) << "an own attempt, taken out of the statistics";
    EXPECT_NE(altered[0].find("listed as imported, its folder has no such mark"), std::string::npos);
}

// HZ-RECORD-07
TEST(Store, ADamagedFinishedAttemptIsNotChangedWhenTheIndexIsLost) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id, someResult(), {}, 4 * kFrameTicks);
    }
    const path inputs = temp / "s" / "attempts" / id / "record" / "inputs.bin";
    std::string bytes = readText(inputs);
    bytes[bytes.size() * 5 / 8] ^= 1;  // in the third frame
    std::ofstream(inputs, std::ios::binary) << bytes;
    deleteIndex(temp / "s");
    const Store store(temp / "s");
    EXPECT_EQ(std::filesystem::file_size(inputs), bytes.size());
    EXPECT_TRUE(readText(inputs) == bytes);
    EXPECT_EQ(store.attempt(id).state, AttemptState::done);
    EXPECT_TRUE(store.recovered().empty());
    ASSERT_EQ(store.openingMessages().size(), 2u);
    EXPECT_NE(store.openingMessages()[1].find("attempt " + id +
                                              " is finished but damaged, and was not "
                                              "changed: record/inputs.bin; whole for 500 ticks"),
              std::string::npos)
        << store.openingMessages()[1];
    ASSERT_EQ(store.damage().size(), 1u) << "although the new checksums match";
    EXPECT_NE(store.damage()[0].find("record/inputs.bin; whole for 500 ticks"), std::string::npos);
}

// HZ-RECORD-01, HZ-RECORD-08
TEST(Store, AFolderThatCannotBeIndexedDoesNotBlockOthers) {
    const test::TempFolder temp;
    std::string bad, no_step, good;
    {
        Store store(temp / "s");
        bad = store.begin(someAttemptInfo("T-01"));
        writeUnfinishedRecord(store.attempt(bad), 10);
        createPrivateFolders(store.attemptFolder(bad) / "record" / "samples.bin");  // a folder
        no_step = store.begin(someAttemptInfo("T-03"));
        StoredAttempt changed = store.attempt(no_step);
        changed.info.dt_s = std::nan("");
        writeUnfinishedRecord(changed, 10);
        good = store.begin(someAttemptInfo("T-02"));
        test::finish(store, good);
    }
    deleteIndex(temp / "s");
    Store store(temp / "s");
    ASSERT_EQ(store.attempts().size(), 1u);
    EXPECT_EQ(store.attempts()[0].id, good);
    EXPECT_TRUE(store.recovered().empty());
    EXPECT_EQ(store.openingMessages().size(), 3u);
    EXPECT_TRUE(contains(store.openingMessages(), "attempts/" + bad + " cannot be indexed: "));
    EXPECT_TRUE(contains(store.openingMessages(), "attempts/" + no_step + " cannot be indexed: "));
    EXPECT_TRUE(contains(store.openingMessages(), "inputs.bin: header: dt_s: must be finite"));
    EXPECT_EQ(store.eraseTrainee("T-02"), 1u);
    EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(good)));
    EXPECT_TRUE(std::filesystem::exists(store.attemptFolder(bad) / "record" / "inputs.bin"));
}

// HZ-RECORD-07
TEST(Store, ARecordInsideTheRecordIsIgnored) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        StoredAttempt nested = store.attempt(id);
        nested.info.trainee = "T-99";
        nested.folder /= "record";
        test::beginRecord(nested).finish(someResult());
        test::finish(store, id);
        EXPECT_EQ(store.attempt(id).info.trainee, "T-01");
        EXPECT_EQ(loadRecord(store.attemptFolder(id) / "record").info.trainee, "T-01");
        EXPECT_EQ(loadRecord(store.attemptFolder(id)).info.trainee, "T-01");
    }
    deleteIndex(temp / "s");
    {
        EXPECT_EQ(Store(temp / "s").attempt(id).info.trainee, "T-01");
    }
    std::filesystem::remove(temp / "s" / "attempts" / id / "record" / "record.json");
    deleteIndex(temp / "s");
    EXPECT_TRUE(Store(temp / "s").attempts().empty()) << "the nested record does not replace a missing one";
}

// HZ-RECORD-01
TEST(Store, IndexingAnAttemptAgainReplacesItsRows) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id, someResult(), {{1, "tool", "finger"}, {2, "tool", "probe"}}, 10);
    }
    for (int i = 0; i < 2; ++i) {
        SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
            .exec("UPDATE attempt SET state = 'running'");
        const Store store(temp / "s");
        EXPECT_TRUE(store.openingMessages().empty());
        const StoredAttempt again = store.attempt(id);
        EXPECT_EQ(again.state, AttemptState::done);
        EXPECT_EQ(again.events.size(), 2u);
        EXPECT_EQ(again.result.value().metrics.size(), 2u);
        EXPECT_EQ(store.files(id).size(), 2u);
        EXPECT_TRUE(store.damage().empty());
    }
}

// The program was killed between the end of the record and finish().
// HZ-RECORD-01
TEST(Store, AnAttemptWithAResultIsDoneEvenIfItsWriterWasKilled) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::beginRecord(store.attempt(id)).finish(someResult());
    }
    const Store store(temp / "s");
    EXPECT_TRUE(store.recovered().empty());
    EXPECT_EQ(store.attempt(id).state, AttemptState::done);
    EXPECT_EQ(store.attempt(id).result.value().total, 87.5);
    EXPECT_EQ(store.outbox().size(), 1u);
}

// HZ-RECORD-07
TEST(Store, ARecordThatCannotBeReadIsNamedAndTheAttemptStaysListed) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        writeUnfinishedRecord(store.attempt(id), 10);
        std::ofstream(store.attemptFolder(id) / "record" / "record.json") << "{\"format_version\": 9";
    }
    const Store store(temp / "s");
    ASSERT_EQ(store.openingMessages().size(), 1u);
    EXPECT_NE(store.openingMessages()[0].find("its record cannot be read: "), std::string::npos);
    EXPECT_NE(store.openingMessages()[0].find("record.json: json"), std::string::npos);
    EXPECT_EQ(store.attempt(id).state, AttemptState::cut_short);
    EXPECT_EQ(store.attempt(id).info.trainee, "T-01");
}

// HZ-RECORD-08
TEST(Store, UnknownFoldersAreNotModified) {
    const test::TempFolder temp;
    std::filesystem::create_directories(temp / "s" / "attempts" / "whose");
    std::ofstream(temp / "s" / "attempts" / "whose" / "thesis.txt") << "precious";
    std::filesystem::create_directories(temp / "s" / "attempts" / "hardly-begun");
    std::ofstream(temp / "s" / "attempts" / "hardly-begun" / ".writing");
    const Store store(temp / "s");
    ASSERT_EQ(store.unknownFolders().size(), 1u);
    EXPECT_EQ(store.unknownFolders()[0].filename(), "whose");
}

}  // namespace
}  // namespace stylet::records
