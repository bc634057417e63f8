// stylet-attempt-writer STORE [FILE_BYTES]: stores attempts at full speed until it is killed. It reports on
// stdout what the store has promised to preserve: "begun ID", "kept ID TICKS" (whole frames), "event ID
// COUNT", "done ID TICKS". FILE_BYTES limits the size of each file. If a write is refused, the program prints
// "refused: ..." and ends with status 3. The environment variable named by kWriterSeed seeds the attempts'
// random lengths.
#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/records/store.h"
#include "patient/package/package.h"
#include "tests/support/attempt_writer.h"

namespace {

using namespace stylet;

// Writes the line in a single write(), so that it appears whole or not at all.
void report(const std::string& line) {
    const std::string text = line + "\n";
    if (write(STDOUT_FILENO, text.data(), text.size()) != ssize_t(text.size())) std::_Exit(4);
}

void writeAttempt(records::Store& store, std::uint64_t ticks) {
    records::AttemptInfo info;
    info.trainee = "T-01";
    info.scenario = "kill";
    const std::string id = store.begin(info);
    report("begun " + id);
    records::RecordInfo recorded;
    recorded.id = id, recorded.trainee = info.trainee, recorded.scenario = info.scenario;
    records::RecordWriter record(store.attemptFolder(id) / "record", {}, recorded);
    records::SampleWriter samples(store.attemptFolder(id) / "record", {});
    std::uint64_t events = 0;
    for (std::uint64_t tick = 1; tick <= ticks; ++tick) {
        record.add(test::inputAt(tick), tick, test::hashAt(tick));
        samples.add(test::sampleAt(tick));
        if (tick % 400 == 0) {
            record.addEvents({{tick, "comment", test::textAt(tick)}});
            report(fmt::format("event {} {}", id, ++events));
        }
        if (tick % records::kFrameTicks == 0) report(fmt::format("kept {} {}", id, tick));
    }
    samples.finish();
    record.finish({true, 50.0, ticks, {{"ticks", "ticks", "", double(ticks), 1.0, 2.0}}});
    store.finish(id);
    report(fmt::format("done {} {}", id, ticks));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    if (argc > 2) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit most{std::strtoull(argv[2], nullptr, 10), RLIM_INFINITY};
        setrlimit(RLIMIT_FSIZE, &most);
    }
    try {
        const char* seed = std::getenv(test::kWriterSeed);
        std::mt19937_64 random(seed ? std::strtoull(seed, nullptr, 10) : 1);
        records::Store store(argv[1]);
        for (;;)
            writeAttempt(store, std::uniform_int_distribution<std::uint64_t>(1, 1500)(random));
    } catch (const DataError& e) {
        report(std::string("refused: ") + e.what());
        return 3;
    }
}
