#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <algorithm>
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
#include "tests/app/records/privacy.h"
#include "tests/app/records/some_result.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using std::filesystem::path;
using test::readText;
using test::someResult;
using test::writeUnfinishedRecord;

AttemptInfo someAttemptInfo(const std::string& trainee = "T-01") {
    AttemptInfo info{trainee, "falcon", "reference patient, seed 1", "demo", "practice", "1.2.3"};
    info.patient_digest = 0xfedcba9876543210ull;
    info.seed = std::numeric_limits<std::uint64_t>::max();
    info.device_gain = 0.25;
    info.registration_rms_m = 0.0011;
    return info;
}

// Deletes the index of a store that is not open.
void deleteIndex(const path& store) {
    for (const char* name : {"store.sqlite", "store.sqlite-wal", "store.sqlite-shm"})
        std::filesystem::remove(store / name);
}

bool contains(const std::vector<std::string>& lines, const std::string& text) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

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

// HZ-RECORD-04, HZ-RECORD-10
TEST(Store, AcceptsPseudonymsOnly) {
    const test::TempFolder temp;
    Store store(temp / "s");
    for (const std::string& bad : {std::string(), std::string("Ann Example"), std::string("../x"),
                                   std::string("a\nb"), std::string(65, 'a'), std::string("\xc3\xa4")})
        EXPECT_NE(test::errorText([&] { store.begin(someAttemptInfo(bad)); }), "") << bad;
    EXPECT_NE(test::errorText([&] { checkTrainee("Ann Example"); }).find("pseudonym"), std::string::npos);
    EXPECT_TRUE(store.attempts().empty());
    EXPECT_NO_THROW(checkTrainee(std::string(64, 'z')));
    EXPECT_NO_THROW(checkTrainee("S-3_b.2"));
}

// A pseudonym that is a folder, a hidden file, an option, or looks like another one.
// HZ-RECORD-10
TEST(Store, PseudonymsThatAreNotPlainAreRefused) {
    const std::vector<std::string> bad{".",
                                       "..",
                                       "...",
                                       ".hidden",
                                       "T-1.",
                                       "T-1 ",
                                       " T-1",
                                       "-rf",
                                       "--out",
                                       "T-1-",
                                       "_",
                                       "a/b",
                                       "a\\b",
                                       "/",
                                       "~",
                                       "*",
                                       "\t",
                                       "T\x1b[31m",
                                       "T\x7f",
                                       std::string("T\0-1", 4),
                                       "\xe2\x80\xa4\xe2\x80\xa4",  // two one dot leaders
                                       "\xef\xbc\x8e\xef\xbc\x8e",  // two fullwidth full stops
                                       "\xd0\xa2-1",                // a Cyrillic letter
                                       "T\xe2\x80\x8b-1",           // a space of no width
                                       "\xc0\xae\xc0\xae"};         // dots in overlong UTF-8
    for (const std::string& one : bad) {
        const std::string text = test::errorText([&] { checkTrainee(one); });
        EXPECT_NE(text.find(": trainee: "), std::string::npos) << one;
        EXPECT_EQ(text.find('\x1b'), std::string::npos) << "would reach the terminal";
    }
    EXPECT_NE(test::errorText([] { checkTrainee(".."); }).find("must begin and end with a letter or digit"),
              std::string::npos);
    for (const char* good : {"a", "7", "a..b", "T-1", "pilot_7"})
        EXPECT_NO_THROW(checkTrainee(good)) << good;
}

// HZ-RECORD-08, HZ-RECORD-10
TEST(Store, ErasesAPseudonymThatIsRefusedToday) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id, someResult());
        test::finish(store, store.begin(someAttemptInfo("T-02")), someResult());
    }
    SQLite::Database((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET trainee = '..' WHERE trainee = 'T-01'");
    Store store(temp / "s");
    EXPECT_EQ(store.eraseTrainee(".."), 1u);
    EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(id)));
    EXPECT_EQ(store.attempts().size(), 1u);
}

// HZ-RECORD-10
TEST(Store, EverythingItWritesIsPrivateWhateverTheUmask) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    Store store(temp / "new" / "s");
    const std::string id = store.begin(someAttemptInfo());
    writeUnfinishedRecord(store.attempt(id), 10);
    const auto sending = FileLock::tryLock(store.folder() / ".sending");
    for (const char* name : {"store.sqlite", "store.sqlite-wal", "store.sqlite-shm", ".reserve"})
        EXPECT_TRUE(std::filesystem::exists(store.folder() / name)) << name;
    EXPECT_TRUE(std::filesystem::exists(store.attemptFolder(id) / ".writing"));
    EXPECT_EQ(test::openEntries(temp / "new"), "");
    std::ofstream(store.attemptFolder(id) / "picture.png") << "from another writer";
    EXPECT_EQ(test::openEntries(store.folder()), "picture.png 666; ");
    test::finish(store, id, someResult());
    EXPECT_EQ(test::openEntries(store.folder()), "");
    store.eraseTrainee("nobody");
    EXPECT_EQ(test::openEntries(store.folder()), "") << "also after a new log";

    std::filesystem::create_directories(temp / "there");
    EXPECT_EQ(test::openEntries(temp / "there"), "there 777; ");
    exportAttempts(store, "", temp / "there");
    EXPECT_EQ(test::openEntries(temp / "there"), "");
}

// HZ-RECORD-10
TEST(Store, AStoreThatIsOpenToOthersIsClosedAndSaysSo) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    std::string id;
    {
        Store store(temp / "s");
        EXPECT_TRUE(store.openingMessages().empty());
        id = store.begin(someAttemptInfo());
        writeUnfinishedRecord(store.attempt(id), 10);
        test::finish(store, id, someResult());
    }
    std::filesystem::permissions(temp / "s", std::filesystem::perms(0755));
    std::filesystem::permissions(temp / "s" / "store.sqlite", std::filesystem::perms(0644));
    std::filesystem::permissions(temp / "s" / "attempts" / id / "record" / "record.json",
                                 std::filesystem::perms(0640));
    {
        const Store store(temp / "s");
        ASSERT_EQ(store.openingMessages().size(), 1u);
        EXPECT_NE(store.openingMessages()[0].find("withdrew the access of group and others"),
                  std::string::npos);
        EXPECT_EQ(test::openEntries(temp / "s"), "");
        EXPECT_EQ(store.attempt(id).state, AttemptState::done);
    }
    EXPECT_TRUE(Store(temp / "s").openingMessages().empty()) << "only once";
}

// HZ-RECORD-10
TEST(Store, AFolderThatIsNoStoreKeepsItsPermissions) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    std::filesystem::create_directories(temp / "other" / "attempts");
    SQLite::Database((temp / "other" / "store.sqlite").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("CREATE TABLE song (name TEXT)");
    EXPECT_THROW(Store(temp / "other"), DataError);
    EXPECT_EQ(test::openEntries(temp / "other").substr(0, 9), "other 777");
}

// HZ-RECORD-10
TEST(Store, OtherFilesBesideTheStoreKeepTheirPermissions) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    {
        const Store store(temp / "s");
    }
    const auto mode = [&](const char* name) {
        return unsigned(std::filesystem::status(temp / "s" / name).permissions());
    };
    std::filesystem::create_directory(temp / "s" / "pictures");
    for (const char* name : {"notes.txt", "pictures/one.png", "attempts/list.txt", ".sending"})
        std::ofstream(temp / "s" / name) << "text";
    for (const char* name : {"store.sqlite", ".reserve"})
        std::filesystem::permissions(temp / "s" / name, std::filesystem::perms(0644));
    const Store store(temp / "s");
    EXPECT_EQ(mode("notes.txt"), 0666u);
    EXPECT_EQ(mode("pictures"), 0777u);
    EXPECT_EQ(mode("pictures/one.png"), 0666u);
    for (const char* name : {"attempts/list.txt", ".sending", "store.sqlite", ".reserve"})
        EXPECT_EQ(mode(name), 0600u) << name;
    EXPECT_EQ(mode(""), 0700u);
}

TEST(Store, AnExportIsNotAStore) {
    const test::TempFolder temp;
    Store store(temp / "s");
    test::finish(store, store.begin(someAttemptInfo()));
    exportAttempts(store, "", temp / "export");
    ASSERT_TRUE(std::filesystem::exists(temp / "export" / "attempts"));
    EXPECT_NE(test::errorText([&] { Store(temp / "export"); }).find("this is an export, not a Stylet store"),
              std::string::npos);
    EXPECT_NE(test::errorText([&] { openExistingStore(temp / "export"); }).find("this is an export"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(temp / "export" / "store.sqlite"));
}

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

// HZ-RECORD-08
TEST(Store, ErasedTraineeLeavesNoBytesOnDisk) {
    const test::TempFolder temp;
    Store store(temp / "s");
    const std::string kept = store.begin(someAttemptInfo("T-02"));
    test::finish(store, kept, someResult());
    for (int i = 0; i < 3; ++i) {
        const std::string id = store.begin(someAttemptInfo("Zebra-77"));
        test::finish(store, id, someResult(), {{1, "comment", "remarkable words"}}, 10);
    }
    EXPECT_EQ(store.eraseTrainee("Zebra-77"), 3u);
    EXPECT_EQ(store.eraseTrainee("Zebra-77"), 0u);
    EXPECT_EQ(store.attempts().size(), 1u);
    int files = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(temp / "s")) {
        if (!entry.is_regular_file()) continue;
        ++files;
        const std::string bytes = readText(entry.path());
        EXPECT_EQ(bytes.find("Zebra-77"), std::string::npos) << entry.path();
        EXPECT_EQ(bytes.find("remarkable"), std::string::npos) << entry.path();
    }
    EXPECT_GE(files, 1);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(temp / "s" / "attempts"), {}), 1);
}

// HZ-RECORD-08
TEST(Store, InterruptedDeletionIsCompleted) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id, {});
        SQLite::Database bare((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE);
        bare.exec("INSERT INTO doomed SELECT id FROM attempt; DELETE FROM attempt");
    }
    const Store store(temp / "s");
    EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(id)));
    EXPECT_TRUE(store.unknownFolders().empty());
}

// HZ-RECORD-08
TEST(Store, DeletionIsRetriedUntilTheLogIsEmpty) {
    const test::TempFolder temp;
    const path file = temp / "s" / "store.sqlite";
    {
        Store store(temp / "s");
        test::finish(store, store.begin(someAttemptInfo("Zebra-77")), someResult());
        SQLite::Database reader(file.string(), SQLite::OPEN_READWRITE);
        SQLite::Statement rows(reader, "SELECT * FROM attempt");
        ASSERT_TRUE(rows.executeStep());  // the open statement keeps a read transaction
        EXPECT_NE(test::errorText([&] { store.eraseTrainee("Zebra-77"); }).find("another process is reading"),
                  std::string::npos);
        EXPECT_TRUE(store.attempts().empty());
    }
    const Store store(temp / "s");
    EXPECT_TRUE(store.openingMessages().empty());
    for (const auto& entry : std::filesystem::directory_iterator(temp / "s"))
        if (entry.is_regular_file()) {
            EXPECT_EQ(readText(entry.path()).find("Zebra-77"), std::string::npos) << entry.path();
        }
    EXPECT_EQ(SQLite::Database(file.string()).execAndGet("SELECT count(*) FROM doomed").getInt(), 0);
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
    refused("format_version: 8 is not 9: the record was written by an older program version");
    test::finish(store, id);
    EXPECT_EQ(store.attempt(id).state, AttemptState::done);
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
    EXPECT_EQ(store.attempt(cut).state, AttemptState::cut_short);
    EXPECT_EQ(store.attempt(cut).events.at(0).text, "probe");
    EXPECT_EQ(store.unknownFolders().size(), 2u) << "a record of another id, and one that cannot be read";
    EXPECT_TRUE(store.damage().empty());
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
    ASSERT_EQ(store.openingMessages().size(), 1u);
    EXPECT_NE(store.openingMessages()[0].find("attempt " + id +
                                              " is finished but damaged, and was not "
                                              "changed: record/inputs.bin; whole for 500 ticks"),
              std::string::npos)
        << store.openingMessages()[0];
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
    EXPECT_EQ(store.openingMessages().size(), 2u);
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

// A deletion that was interrupted must not be undone because the folder is still there.
// HZ-RECORD-08
TEST(Store, DeletedAttemptsAreNotIndexedAgain) {
    const test::TempFolder temp;
    std::string id;
    {
        Store store(temp / "s");
        id = store.begin(someAttemptInfo());
        test::finish(store, id);
        SQLite::Database bare((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE);
        bare.exec("INSERT INTO doomed SELECT id FROM attempt; DELETE FROM attempt");
        SQLite::Statement rows(bare, "SELECT * FROM doomed");
        ASSERT_TRUE(rows.executeStep());  // blocks the deletion's last step
        const Store other(temp / "s");
        EXPECT_TRUE(other.attempts().empty());
    }
    EXPECT_TRUE(Store(temp / "s").attempts().empty());
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

// HZ-RECORD-08
TEST(Store, ForgedIdsCannotDeleteOtherFolders) {
    const test::TempFolder temp;
    std::filesystem::create_directories(temp / "precious");
    for (const std::string& id :
         std::vector<std::string>{"..", ".", "", "../../precious", (temp / "precious").string()}) {
        std::filesystem::remove_all(temp / "s");
        std::string kept, erased;
        {
            Store store(temp / "s");
            kept = store.begin(someAttemptInfo("T-02"));
            test::finish(store, kept, someResult());
            erased = store.begin(someAttemptInfo("T-03"));
            test::finish(store, erased, someResult());
            test::finish(store, store.begin(someAttemptInfo("T-01")), someResult());
            SQLite::Database other((temp / "s" / "store.sqlite").string(), SQLite::OPEN_READWRITE);
            SQLite::Statement forged(other, "UPDATE attempt SET id = ? WHERE trainee = 'T-01'");
            forged.bind(1, id);
            forged.exec();
            EXPECT_EQ(store.eraseTrainee("T-01"), 1u) << id << ": found again by its record";
            // The state after an interrupted deletion of T-03.
            SQLite::Statement doomed(other, "INSERT INTO doomed (folder) VALUES (?), (?)");
            doomed.bind(1, id);
            doomed.bind(2, erased);
            doomed.exec();
        }
        const Store store(temp / "s");
        EXPECT_FALSE(std::filesystem::exists(store.attemptFolder(erased))) << id;
        EXPECT_TRUE(store.attempts("T-01").empty()) << id;
        EXPECT_TRUE(std::filesystem::is_directory(temp / "precious")) << id;
        EXPECT_TRUE(std::filesystem::is_directory(store.attemptFolder(kept))) << id;
        EXPECT_EQ(store.attempt(kept).info.trainee, "T-02") << id;
    }
}

}  // namespace
}  // namespace stylet::records
