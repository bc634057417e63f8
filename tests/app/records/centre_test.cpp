// Tests the outbox against a real PostgreSQL server.
#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <limits>
#include <mutex>
#include <pqxx/pqxx>
#include <thread>

#include "app/records/outbox.h"
#include "patient/package/package.h"
#include "tests/app/records/some_result.h"
#include "tests/support/postgres.h"

namespace stylet::records {
namespace {

using std::chrono::steady_clock;
using test::someResult;
using namespace std::chrono_literals;

constexpr auto kTimeout = 120s;

// Stores an attempt with its record and two more files. One needs several parts to send, the other is empty.
std::string someAttempt(Store& store, const std::string& trainee = "T-01") {
    AttemptInfo info{trainee, "falcon", "Zo\xc3\xab \"7\"", "demo", "exam", "1.2.3"};
    info.seed = std::numeric_limits<std::uint64_t>::max();
    info.registration_rms_m = 0.0011;
    const std::string id = store.begin(info);
    std::string big(2'500'000, '\0');
    for (std::size_t i = 0; i < big.size(); ++i)
        big[i] = char(i * i >> 7);
    std::filesystem::create_directories(store.attemptFolder(id) / "record");
    std::ofstream(store.attemptFolder(id) / "record" / "samples.bin", std::ios::binary) << big;
    std::ofstream(store.attemptFolder(id) / "empty.txt");
    // Text as a terminal may deliver it: not UTF-8, with a NUL.
    test::finish(store, id, someResult(),
                 {{1, "tool", "finger"}, {700, "comment", std::string("caf\xe9 \0 \\ '", 10)}});
    return id;
}

class OutboxTest : public ::testing::Test {
  protected:
    static void SetUpTestSuite() { postgres_ = new test::Postgres; }
    static void TearDownTestSuite() { delete postgres_; }
    void SetUp() override { query("DROP SCHEMA IF EXISTS stylet CASCADE"); }

    static pqxx::result query(const std::string& sql) {
        pqxx::connection connection(postgres_->url());
        pqxx::work work(connection);
        const pqxx::result rows = work.exec(sql);
        work.commit();
        return rows;
    }
    static std::int64_t count(const std::string& table) {
        return query("SELECT count(*) FROM stylet." + table)[0][0].as<std::int64_t>();
    }
    template <typename Condition>
    static bool waitUntilTrue(const Condition& condition) {
        for (const auto end = steady_clock::now() + kTimeout; steady_clock::now() < end;) {
            if (condition()) return true;
            std::this_thread::sleep_for(20ms);
        }
        return false;
    }

    static inline test::Postgres* postgres_ = nullptr;
    test::TempFolder folder_;
    Store store_{folder_ / "s"};
};

TEST_F(OutboxTest, SendsAttemptCompletely) {
    const std::string id = someAttempt(store_);
    const SendReport report = sendOutbox(store_, postgres_->url());
    EXPECT_EQ(report.error, "");
    EXPECT_EQ(report.sent, 1u);
    EXPECT_EQ(report.left, 0u);
    EXPECT_TRUE(store_.outbox().empty());

    const pqxx::result attempt = query("SELECT * FROM stylet.attempt");
    ASSERT_EQ(attempt.size(), 1u);
    EXPECT_EQ(attempt[0]["id"].as<std::string>(), id);
    EXPECT_EQ(attempt[0]["trainee"].as<std::string>(), "T-01");
    EXPECT_EQ(attempt[0]["patient"].as<std::string>(), "Zo\xc3\xab \"7\"");
    EXPECT_EQ(attempt[0]["seed"].as<std::string>(), "18446744073709551615");
    EXPECT_EQ(attempt[0]["registration_rms_m"].as<double>(), 0.0011);
    EXPECT_EQ(attempt[0]["total"].as<double>(), 87.5);
    EXPECT_EQ(attempt[0]["ticks"].as<std::int64_t>(), 12345);
    EXPECT_EQ(query("SELECT to_char(started_utc AT TIME ZONE 'utc', 'YYYY-MM-DD\"T\"HH24:MI:SS.MS\"Z\"') "
                    "FROM stylet.attempt")[0][0]
                  .as<std::string>(),
              store_.attempt(id).started_utc);
    const pqxx::result metrics = query("SELECT value::text, points FROM stylet.metric ORDER BY place");
    ASSERT_EQ(metrics.size(), 2u);
    EXPECT_EQ(metrics[0][0].as<std::string>(), "Infinity");
    EXPECT_EQ(metrics[0][1].as<double>(), 10.0);
    EXPECT_EQ(metrics[1][0].as<std::string>(), "NaN");
    const pqxx::result events = query("SELECT tick, kind, text FROM stylet.event ORDER BY place");
    ASSERT_EQ(events.size(), 2u);
    EXPECT_EQ(events[1][0].as<int>(), 700);
    EXPECT_EQ(events[1][2].as<std::string>(), "caf\xef\xbf\xbd  \\ '") << "what is no text is marked";

    pqxx::connection connection(postgres_->url());
    pqxx::work work(connection);
    std::string content;
    for (const pqxx::row& part : work.exec("SELECT content FROM stylet.file_part WHERE path = "
                                           "'record/samples.bin' ORDER BY part"))
        content += pqxx::binarystring(part[0]).str();
    std::ifstream stored(store_.attemptFolder(id) / "record" / "samples.bin", std::ios::binary);
    EXPECT_TRUE(content == std::string(std::istreambuf_iterator<char>(stored), {}));
    EXPECT_EQ(count("file"), 4);
}

// HZ-RECORD-09
TEST_F(OutboxTest, SendingTwiceStoresOnce) {
    const std::string id = someAttempt(store_);
    ASSERT_EQ(sendOutbox(store_, postgres_->url()).sent, 1u);
    // The state of a program that was killed after the centre acknowledged, before it updated its own outbox.
    SQLite::Database(store_.folder() / "store.sqlite", SQLite::OPEN_READWRITE)
        .exec("INSERT INTO outbox (kind, what) SELECT 'attempt', id FROM attempt");
    const SendReport again = sendOutbox(store_, postgres_->url());
    EXPECT_EQ(again.error, "");
    EXPECT_EQ(again.left, 0u);
    EXPECT_EQ(count("attempt"), 1);
    EXPECT_EQ(count("metric"), 2);
    EXPECT_EQ(count("event"), 2);
    EXPECT_EQ(count("file_part"), 5);
}

// HZ-RECORD-08
TEST_F(OutboxTest, DeletionReachesTheCentre) {
    someAttempt(store_, "T-01");
    const std::string kept = someAttempt(store_, "T-02");
    ASSERT_EQ(sendOutbox(store_, postgres_->url()).sent, 2u);
    store_.eraseTrainee("T-01");
    const SendReport report = sendOutbox(store_, postgres_->url());
    EXPECT_EQ(report.erased, 1u);
    EXPECT_EQ(report.left, 0u);
    EXPECT_EQ(query("SELECT id FROM stylet.attempt")[0][0].as<std::string>(), kept);
    for (const char* table : {"attempt", "metric", "event", "file", "file_part"})
        EXPECT_EQ(query("SELECT count(*) FROM stylet." + std::string(table) + " WHERE " +
                        (std::string(table) == "attempt" ? "id" : "attempt") + " <> '" + kept + "'")[0][0]
                      .as<int>(),
                  0)
            << table;
}

// Site B imports a copy of an attempt of site A, and sends it first.
// HZ-RECORD-09
TEST_F(OutboxTest, TheOriginalReplacesItsCopyAtTheCentre) {
    const std::string id = someAttempt(store_), own = someAttempt(store_);
    Store(folder_ / "b").begin({"T-09", "falcon", "x", "demo", "exam", "1.2.3"});
    std::filesystem::copy(store_.attemptFolder(id), folder_ / "b" / "attempts" / id,
                          std::filesystem::copy_options::recursive);
    std::filesystem::remove(folder_ / "b" / "attempts" / id / "empty.txt");
    Store b(folder_ / "b");
    ASSERT_TRUE(b.attempt(id).imported);
    const auto atCentre = [&](const char* column) {
        return query(fmt::format("SELECT {} FROM stylet.attempt WHERE id = '{}'", column, id));
    };
    EXPECT_EQ(sendOutbox(b, postgres_->url()).error, "");
    ASSERT_EQ(atCentre("imported").size(), 1u);
    EXPECT_TRUE(atCentre("imported")[0][0].as<bool>());
    EXPECT_EQ(sendOutbox(store_, postgres_->url()).sent, 2u);
    EXPECT_FALSE(atCentre("imported")[0][0].as<bool>());
    EXPECT_EQ(query("SELECT 1 FROM stylet.file WHERE attempt = '" + id + "' AND path = 'empty.txt'").size(),
              1u)
        << "with its own files";
    // The copy again, and its removal, leave the original.
    SQLite::Database(b.folder() / "store.sqlite", SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET difficulty = 'practice'");
    b.discard(id);
    EXPECT_EQ(sendOutbox(b, postgres_->url()).error, "");
    EXPECT_EQ(atCentre("id").size(), 1u);
    EXPECT_EQ(count("attempt"), 3) << own;
}

// An erased attempt comes back from a backup, as an imported one, before the centre was told of its erasure.
// HZ-RECORD-08
TEST_F(OutboxTest, DiscardingACopyKeepsAnEarlierDeletion) {
    const std::string id = someAttempt(store_, "T-01");
    someAttempt(store_, "T-02");
    ASSERT_EQ(sendOutbox(store_, postgres_->url()).sent, 2u);
    std::filesystem::copy(store_.attemptFolder(id), folder_ / "backup",
                          std::filesystem::copy_options::recursive);
    store_.eraseTrainee("T-01");
    std::filesystem::copy(folder_ / "backup", store_.attemptFolder(id),
                          std::filesystem::copy_options::recursive);
    Store again(store_.folder());
    ASSERT_TRUE(again.attempt(id).imported);
    SQLite::Database(again.folder() / "store.sqlite", SQLite::OPEN_READWRITE)
        .exec("UPDATE attempt SET difficulty = 'practice'");
    again.discard(id);
    EXPECT_EQ(sendOutbox(again, postgres_->url()).erased, 1u);
    EXPECT_EQ(count("attempt"), 1);
}

TEST_F(OutboxTest, ChangedFileStaysQueuedAndDoesNotBlockOthers) {
    const std::string bad = someAttempt(store_), good = someAttempt(store_);
    std::ofstream(store_.attemptFolder(bad) / "empty.txt") << "not any more";
    const SendReport report = sendOutbox(store_, postgres_->url());
    EXPECT_EQ(report.sent, 1u);
    EXPECT_EQ(report.left, 1u);
    EXPECT_NE(report.error.find("empty.txt"), std::string::npos) << report.error;
    ASSERT_EQ(store_.outbox().size(), 1u);
    EXPECT_EQ(store_.outbox()[0].attempt_id, bad);
    EXPECT_EQ(store_.outbox()[0].tries, 1u);
    EXPECT_EQ(query("SELECT id FROM stylet.attempt")[0][0].as<std::string>(), good);
    EXPECT_EQ(count("attempt"), 1) << "nothing of the other";
}

// HZ-RECORD-09
TEST_F(OutboxTest, UnreachableDatabaseLosesNothing) {
    someAttempt(store_);
    postgres_->stop();
    const SendReport gone = sendOutbox(store_, postgres_->url());
    EXPECT_FALSE(gone.reached);
    EXPECT_EQ(gone.left, 1u);
    EXPECT_NE(gone.error, "");
    EXPECT_EQ(gone.error.find('\n'), std::string::npos);
    someAttempt(store_);
    postgres_->start();
    EXPECT_EQ(sendOutbox(store_, postgres_->url()).sent, 2u);
    EXPECT_EQ(count("attempt"), 2);
    for (const std::string& nowhere :
         {std::string("postgresql://127.0.0.1:1/x"), std::string("host=/nonexistent"),
          std::string("nonsense=1"), std::string("%%")}) {
        someAttempt(store_);
        EXPECT_EQ(sendOutbox(store_, nowhere).sent, 0u) << nowhere;
    }
}

// HZ-RECORD-03
TEST_F(OutboxTest, OnlyOneSenderRunsAtATime) {
    someAttempt(store_);
    const auto other = FileLock::tryLock(store_.folder() / ".sending");
    ASSERT_TRUE(other);
    const SendReport report = sendOutbox(store_, postgres_->url());
    EXPECT_EQ(report.left, 1u);
    EXPECT_NE(report.error.find("another process"), std::string::npos);
}

TEST_F(OutboxTest, RefusesNewerCentreSchema) {
    someAttempt(store_);
    query(
        "CREATE SCHEMA stylet; CREATE TABLE stylet.schema_version (version integer); INSERT INTO "
        "stylet.schema_version VALUES (99)");
    EXPECT_NE(sendOutbox(store_, postgres_->url()).error.find("99 is newer"), std::string::npos);
    EXPECT_EQ(store_.outbox().size(), 1u);
}

// Attempts are stored and sent while the server repeatedly stops and restarts.
// HZ-RECORD-09
TEST_F(OutboxTest, ServerRestartsLoseNothing) {
    std::atomic<int> stored = 0, restarts = 0;
    {
        BackgroundSender sender(store_.folder(), postgres_->url(), [](const std::string&) {});
        std::jthread trainee([&](const std::stop_token& enough) {
            Store store(store_.folder());
            while (!enough.stop_requested()) {
                if (stored >= 4 * (restarts + 1)) {
                    std::this_thread::sleep_for(1ms);
                    continue;
                }
                someAttempt(store);
                ++stored;
                (void)sender.drain(0ms);  // send now
            }
        });
        for (; restarts < 4; ++restarts) {
            EXPECT_TRUE(waitUntilTrue([&] { return stored >= 4 * restarts + 2; }));
            postgres_->stop();
            postgres_->start();
        }
        trainee.request_stop();
        trainee.join();
        EXPECT_TRUE(waitUntilTrue([&] { return sender.drain(kTimeout) == 0 && store_.outbox().empty(); }));
    }
    EXPECT_GT(stored, 4);
    EXPECT_EQ(count("attempt"), stored);
    EXPECT_EQ(count("metric"), 2 * stored);
    EXPECT_EQ(count("file_part"), 5 * stored);
}

// Another session locks the table. The sender blocks in the database, but storing attempts is not delayed.
// HZ-RECORD-09
TEST_F(OutboxTest, BlockedDatabaseDoesNotDelayStorage) {
    someAttempt(store_);
    ASSERT_EQ(sendOutbox(store_, postgres_->url()).sent, 1u);
    someAttempt(store_);
    pqxx::connection blocker(postgres_->url());
    pqxx::work block(blocker);
    block.exec("LOCK TABLE stylet.attempt IN ACCESS EXCLUSIVE MODE");
    {
        BackgroundSender sender(store_.folder(), postgres_->url(), [](const std::string&) {});
        (void)sender.drain(0ms);  // send now
        pqxx::connection watcher(postgres_->url());
        ASSERT_TRUE(waitUntilTrue([&] {
            pqxx::work work(watcher);
            return work.exec("SELECT 1 FROM pg_stat_activity WHERE wait_event_type = 'Lock'").size() == 1;
        })) << "the sender waits";
        for (int i = 0; i < 5; ++i)
            someAttempt(store_);
        EXPECT_EQ(store_.outbox().size(), 6u) << "stored while the sender waits";
        EXPECT_EQ(watcher.is_open(), true);
    }  // the sender stops although the database never answered
    block.abort();
    EXPECT_EQ(sendOutbox(store_, postgres_->url()).sent, 6u);
    EXPECT_EQ(count("attempt"), 7);
}

TEST_F(OutboxTest, DrainWaitsForNewAttempts) {
    BackgroundSender sender(store_.folder(), postgres_->url(), [](const std::string&) {});
    EXPECT_EQ(sender.drain(kTimeout), 0u);
    someAttempt(store_);
    EXPECT_EQ(sender.drain(kTimeout), 0u);
    EXPECT_EQ(count("attempt"), 1);
    postgres_->stop();
    someAttempt(store_);
    const auto before = steady_clock::now();
    EXPECT_EQ(sender.drain(kTimeout), 1u);
    EXPECT_LT(steady_clock::now() - before, kTimeout) << "a refusal is an answer";
    postgres_->start();
}

TEST_F(OutboxTest, BackgroundSenderReportsAnErrorOnceAndRetries) {
    postgres_->stop();
    std::mutex mutex;
    std::vector<std::string> said;
    {
        BackgroundSender sender(store_.folder(), postgres_->url(), [&](const std::string& text) {
            // Messages that a server sends only while it starts.
            for (const char* passing : {"starting up", "not yet accepting"})
                if (text.find(passing) != std::string::npos) return;
            const std::lock_guard lock(mutex);
            said.push_back(text);
        });
        someAttempt(store_);
        EXPECT_EQ(sender.drain(kTimeout), 1u);
        EXPECT_EQ(sender.drain(kTimeout), 1u);  // the same error again
        postgres_->start();
        EXPECT_TRUE(waitUntilTrue([&] { return store_.outbox().empty(); }));
    }
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("the training centre: "), std::string::npos);
    EXPECT_NE(said[0].find("are sent later"), std::string::npos);
    EXPECT_EQ(count("attempt"), 1);
}

}  // namespace
}  // namespace stylet::records
