// Who may read a store, whose names it accepts, and what an erased trainee leaves behind.
#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <vector>

#include "app/records/commands.h"
#include "app/records/export.h"
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
using test::readText;
using test::someAttemptInfo;
using test::someResult;
using test::writeUnfinishedRecord;

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

void expectDeletionIsRetriedUntilTheLogIsEmpty() {
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

// A deletion that was interrupted must not be undone because the folder is still there.
void expectDeletedAttemptsAreNotIndexedAgain() {
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

// A reader blocks the deletion. Each case waits for it until the time limit of 10 s. One of them runs in a
// child process, at the same time.
// HZ-RECORD-08
TEST(Store, BlockedDeletionsAreRetriedAndNotUndone) {
    const pid_t child = fork();
    ASSERT_NE(child, -1);
    if (child == 0) {
        try {
            expectDeletionIsRetriedUntilTheLogIsEmpty();
        } catch (...) {
            _exit(2);  // must not run the other tests
        }
        _exit(HasFailure() ? 1 : 0);
    }
    expectDeletedAttemptsAreNotIndexedAgain();
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << "a deletion is not retried until the log is empty";
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
