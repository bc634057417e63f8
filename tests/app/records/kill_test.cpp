// Kills the writer with SIGKILL at any time. Acknowledged data must survive. The rest is cut at the last
// whole frame and reported.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <thread>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/records/store.h"
#include "patient/package/package.h"
#include "tests/app/records/some_result.h"
#include "tests/support/attempt_writer.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using std::filesystem::path;

#ifdef STYLET_LONG_TESTS
constexpr int kKills = 2000;
#elif defined(STYLET_SANITIZED)
constexpr int kKills = 20;
#else
constexpr int kKills = 100;
#endif
constexpr int kKillsPerStore = 10;

// What the store acknowledged to the writer for one attempt.
struct Acknowledged {
    std::uint64_t kept = 0, events = 0;
    std::optional<std::uint64_t> done;
};

struct Writer {
    std::map<std::string, Acknowledged> acknowledgements;
    std::string refused;
    int status = 0;
};

// Puts the temporary folder in memory, which is faster. SIGKILL does not affect the kernel's page cache, so
// the test needs no real disk.
void useMemoryTempFolder() {
    if (access("/dev/shm", W_OK) == 0) setenv("TMPDIR", "/dev/shm", 0);
}

path writerProgram() {
    return path(std::getenv("STYLET_BIN")).parent_path() / "tests" / "stylet-attempt-writer";
}

struct Kill {
    int lines = 0;  // Wait for this many lines of output first, however slow the machine is.
    int us = 0;     // Then wait this long before the kill.
};

// Each call uses a new seed, so that the attempts differ in length.
Writer runWriter(const path& store, std::optional<Kill> end, const std::string& file_bytes = "") {
    static std::uint64_t writers = 0;
    setenv(test::kWriterSeed, std::to_string(test::seed() + ++writers).c_str(), 1);
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    const std::string program = writerProgram().string(), folder = store.string();
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]), close(ends[1]);
        execl(program.c_str(), program.c_str(), folder.c_str(),
              file_bytes.empty() ? nullptr : file_bytes.c_str(), nullptr);
        _exit(127);
    }
    close(ends[1]);
    std::string output;
    std::array<char, 4096> part{};
    const auto readOutput = [&] {
        const ssize_t n = read(ends[0], part.data(), part.size());
        if (n > 0) output.append(part.data(), std::size_t(n));
        return n > 0;
    };
    if (end) {
        while (std::count(output.begin(), output.end(), '\n') < end->lines && readOutput()) {
        }
        std::this_thread::sleep_for(std::chrono::microseconds(end->us));
        kill(child, SIGKILL);
    }
    while (readOutput()) {
    }
    Writer writer;
    waitpid(child, &writer.status, 0);
    close(ends[0]);
    std::istringstream lines(output);
    for (std::string line, what, id; std::getline(lines, line);) {
        std::istringstream words(line);
        std::uint64_t count = 0;
        words >> what >> id >> count;
        if (what == "refused:") {
            writer.refused = line;
            continue;
        }
        Acknowledged& acknowledgements = writer.acknowledgements[id];
        if (what == "kept") acknowledgements.kept = count;
        if (what == "event") acknowledgements.events = count;
        if (what == "done") acknowledgements.done = count;
    }
    return writer;
}

struct Counts {
    int done = 0, cut = 0, unreported = 0, torn = 0;
};

// Compares every attempt in the store with what was acknowledged.
void check(const Store& store, const std::map<std::string, Acknowledged>& acknowledgements, Counts& counts) {
    std::map<std::string, StoredAttempt> stored;
    for (StoredAttempt& attempt : store.attempts())
        stored[attempt.id] = std::move(attempt);
    for (const auto& [id, promise] : acknowledgements) {
        ASSERT_TRUE(stored.contains(id)) << id << " was begun";
        const StoredAttempt& attempt = stored[id];
        ASSERT_NE(attempt.state, AttemptState::running);
        if (promise.done) {
            ASSERT_EQ(attempt.state, AttemptState::done) << id << " was acknowledged";
            ASSERT_EQ(attempt.result->ticks, *promise.done);
            ASSERT_EQ(attempt.result->metrics.size(), 1u);
        }
        (attempt.state == AttemptState::done ? counts.done : counts.cut) += 1;
        if (attempt.state == AttemptState::done && !promise.done)
            ++counts.unreported;  // killed before it could report this
        ASSERT_GE(attempt.events.size(), promise.events);
        for (std::size_t i = 0; i < attempt.events.size(); ++i)
            ASSERT_EQ(attempt.events[i].text, test::textAt((i + 1) * 400));

        // Killed before the header was complete. Nothing had been acknowledged by then.
        if (promise.kept == 0 && attempt.state == AttemptState::cut_short) continue;
        const Record record = loadRecord(attempt.folder / "record");
        const Samples samples = loadSamples(attempt.folder / "record");
        ASSERT_EQ(record.torn_bytes, 0u);
        ASSERT_EQ(samples.torn_bytes, 0u);
        ASSERT_GE(record.inputs.size(), promise.kept);
        ASSERT_GE(samples.samples.size(), promise.kept);
        if (attempt.result) {
            ASSERT_EQ(record.inputs.size(), attempt.result->ticks);
            ASSERT_EQ(samples.samples.size(), attempt.result->ticks);
        }
        for (std::uint64_t tick = 1; tick <= samples.samples.size(); ++tick)
            ASSERT_EQ(samples.samples[tick - 1].faults, test::sampleAt(tick).faults);
        for (const Checkpoint& checkpoint : record.checkpoints)
            ASSERT_EQ(checkpoint.state_hash, test::hashAt(checkpoint.ticks));
    }
    ASSERT_TRUE(store.damage().empty()) << store.damage()[0];
    ASSERT_TRUE(store.unknownFolders().empty());
}

// HZ-RECORD-01
TEST(Kill, AcknowledgedDataSurvivesAndRecoveryIsReported) {
    useMemoryTempFolder();
    std::mt19937_64 random(test::seed());
    Counts counts;
    int reported = 0;
    for (int kills = 0; kills < kKills;) {
        const test::TempFolder temp;
        std::map<std::string, Acknowledged> acknowledgements;
        for (int i = 0; i < kKillsPerStore; ++i, ++kills) {
            // The kill comes at any time from before the store is opened until after several attempts.
            const Kill end{std::uniform_int_distribution<int>(0, 40)(random),
                           std::uniform_int_distribution<int>(0, 8000)(random)};
            Writer writer = runWriter(temp / "s", end);
            ASSERT_TRUE(WIFSIGNALED(writer.status)) << "the writer ended by itself: " << writer.refused;
            acknowledgements.merge(writer.acknowledgements);
            const Store store(temp / "s");
            reported += int(store.recovered().size());
            for (const RecoveredAttempt& cut : store.recovered())
                for (const TruncatedFile& file : cut.files)
                    counts.torn += file.truncated_bytes > 0;
        }
        check(Store(temp / "s"), acknowledgements, counts);
        if (HasFatalFailure()) return;
    }
    std::printf("%d kills: %d attempts whole (%d of them not yet said so), %d cut short, %d torn files\n",
                kKills, counts.done, counts.unreported, counts.cut, counts.torn);
    EXPECT_GT(counts.cut, kKills / 10);
    EXPECT_GT(counts.done, kKills / 10);
    EXPECT_GE(reported, counts.cut) << "each of them was reported";
}

// A file size limit stands in for a full disk: first the records reach it, then the index.
// HZ-RECORD-02
TEST(DiskFull, IsReportedAndLosesNoStoredData) {
    for (const std::uint64_t room : {0, 4000, 30000, 70000, 150000}) {
        const test::TempFolder temp;
        Counts counts;
        std::map<std::string, Acknowledged> acknowledgements =
            runWriter(temp / "s", Kill{60, 0}).acknowledgements;
        const Writer full = runWriter(temp / "s", std::nullopt, std::to_string(room));
        EXPECT_EQ(WEXITSTATUS(full.status), 3) << room;
        EXPECT_NE(full.refused.find((temp / "s").string()), std::string::npos)
            << "names the file: " << full.refused;
        const Store store(temp / "s");
        for (const auto& [id, promise] : full.acknowledgements)
            if (promise.done) acknowledgements[id] = promise;
        check(store, acknowledgements, counts);
        if (HasFatalFailure()) return;
    }
}

struct Mounted {
    path folder;
    ~Mounted() { umount(folder.c_str()); }
};

// Uses a real disk (tmpfs) if the tester may mount one.
// HZ-RECORD-02
TEST(DiskFull, RealFullDiskLosesNoAcknowledgedData) {
    const test::TempFolder temp;
    std::filesystem::create_directory(temp / "disk");
    if (mount("tmpfs", (temp / "disk").c_str(), "tmpfs", 0, "size=4m") != 0) {
        std::printf(
            "no disk may be mounted here: only a limit on files was tried, above, and no full disk\n");
        return;
    }
    const Mounted mounted{temp / "disk"};
    const Writer full = runWriter(temp / "disk" / "s", std::nullopt);
    Counts counts;
    EXPECT_EQ(WEXITSTATUS(full.status), 3);
    EXPECT_NE(full.refused.find("disk"), std::string::npos) << full.refused;
    {
        // Now there is free space again, as if a user had deleted other files.
        std::map<std::string, Acknowledged> acknowledged;
        for (const auto& [id, promise] : full.acknowledgements)
            if (promise.done) acknowledged[id] = promise;
        EXPECT_GT(acknowledged.size(), 0u);
        {
            Store full_still(temp / "disk" / "s");
            EXPECT_GE(full_still.attempts().size(), acknowledged.size()) << "reading needs no room";
            for (const std::string& line : full_still.openingMessages())
                std::printf("while full: %s\n", line.c_str());
        }
        EXPECT_EQ(mount("tmpfs", (temp / "disk").c_str(), "tmpfs", MS_REMOUNT, "size=6m"), 0);
        const Store store(temp / "disk" / "s");
        check(store, acknowledged, counts);
    }
}

// HZ-RECORD-02
TEST(DiskFull, DeletingFreesSpace) {
    const test::TempFolder temp;
    std::filesystem::create_directory(temp / "disk");
    if (mount("tmpfs", (temp / "disk").c_str(), "tmpfs", 0, "size=4m") != 0) {
        std::printf("no disk may be mounted here\n");
        return;
    }
    const Mounted mounted{temp / "disk"};
    EXPECT_EQ(WEXITSTATUS(runWriter(temp / "disk" / "s", std::nullopt).status), 3);
    Store store(temp / "disk" / "s");
    EXPECT_GT(store.eraseTrainee("T-01"), 0u);
    EXPECT_TRUE(store.attempts().empty());
    EXPECT_TRUE(store.damage().empty());
    AttemptInfo info;
    info.trainee = "T-02";
    test::finish(store, store.begin(info), {});
    EXPECT_EQ(Store(temp / "disk" / "s").attempts().size(), 1u);
}

// Other files have taken the last byte, after the store was closed.
// HZ-RECORD-02, HZ-RECORD-08
TEST(DiskFull, AStoreOnAFilledDiskCanBeReadAndDeleted) {
    const test::TempFolder temp;
    std::filesystem::create_directory(temp / "disk");
    if (mount("tmpfs", (temp / "disk").c_str(), "tmpfs", 0, "size=4m") != 0) {
        std::printf("no disk may be mounted here\n");
        return;
    }
    const Mounted mounted{temp / "disk"};
    {
        Store store(temp / "disk" / "s");
        AttemptInfo info;
        info.trainee = "T-01";
        test::finish(store, store.begin(info), {});
    }
    std::ofstream(temp / "disk" / "other") << std::string(4 << 20, 'x');
    ASSERT_EQ(std::filesystem::space(temp / "disk").available, 0u);
    Store store(temp / "disk" / "s");
    EXPECT_EQ(store.attempts().size(), 1u);
    EXPECT_EQ(store.eraseTrainee("T-01"), 1u);
    EXPECT_TRUE(store.attempts().empty());
}

}  // namespace
}  // namespace stylet::records
