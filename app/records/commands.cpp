#include "app/records/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/records/export.h"
#include "app/records/outbox.h"
#include "app/records/record.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace {

const char* plural(std::size_t count) {
    return count == 1 ? "" : "s";
}

// A dash if there is no such number: the depth of a puncture that was never made, for instance.
std::string shownNumber(double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–";
}

// Text of a record may contain control characters, which a terminal would execute. They become '?', and a tab
// a space.
std::string printable(std::string text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        // U+0080 to U+009F are controls too. In UTF-8 they are 0xC2 and a byte below 0xA0.
        const bool second = i > 0 && text[i - 1] == '\xC2' && c >= 0x80 && c < 0xa0;
        if (c == '\t')
            text[i] = ' ';
        else if (c < 0x20 || c == 0x7f || second)
            text[i] = '?';
    }
    return text;
}

// Prints a line on stdout or, with the program's name, on stderr.
void printLine(const std::string& line) {
    std::printf("%s\n", printable(line).c_str());
}
void reportLine(const std::string& line, const char* program = "stylet") {
    std::fprintf(stderr, "%s: %s\n", program, printable(line).c_str());
}

}  // namespace

std::vector<std::string> reportAlteredRows(const std::vector<StoredAttempt>& attempts, const char* program) {
    std::vector<std::string> lines = findAlteredRows(attempts);
    for (const std::string& line : lines)
        reportLine(line, program);
    return lines;
}

Store openExistingStore(const std::filesystem::path& folder, const char* program) {
    // The index alone may be lost: the store fills it again.
    if (!std::filesystem::exists(folder / "store.sqlite") && !std::filesystem::exists(folder / "attempts"))
        throw DataError(folder, "store", "does not exist; \"stylet run --trainee ID\" creates it");
    Store store(folder);
    for (const std::string& line : store.openingMessages())
        reportLine(line, program);
    return store;
}

int listAttempts(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const std::vector<StoredAttempt> attempts = store.attempts(options.trainee);
    int width = 9;
    for (const StoredAttempt& a : attempts)
        width = std::max(width, int(stateText(a).size()));
    if (!attempts.empty())
        std::printf("%-25s  %-16s  %-*s  %-16s  %-8s  %-6s  %s\n", "attempt", "trainee", width, "state",
                    "scenario", "level", "target", "score");
    for (const StoredAttempt& a : attempts) {
        const std::string outcome =
            a.result ? fmt::format("{:<6}  {:5.1f}", a.result->target_hit ? "hit" : "missed", a.result->total)
                     : "-           -";
        printLine(fmt::format("{:<25}  {:<16}  {:<{}}  {:<16}  {:<8}  {}", a.id, a.info.trainee, stateText(a),
                              width, a.info.scenario, a.info.difficulty, outcome));
    }
    std::printf("%zu attempt%s\n", attempts.size(), plural(attempts.size()));
    reportAlteredRows(attempts);
    return 0;
}

int showAttempt(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const StoredAttempt a = store.attempt(options.id);
    printLine(fmt::format("attempt {} of {}, {}", a.id, a.info.trainee, stateText(a)));
    printLine(fmt::format("  started {}; {}, seed {}; scenario {}, {}; device {}, gain {:.3f}; program {}",
                          a.started_utc, a.info.patient, a.info.seed, a.info.scenario, a.info.difficulty,
                          a.info.device, a.info.device_gain, a.info.program_version));
    if (a.info.registration_rms_m)
        std::printf("  registration error %.2f mm (root mean square)\n", *a.info.registration_rms_m * 1000.0);
    if (a.result) {
        std::printf("  target %s, score %.1f (score table %llu), %llu ticks\n",
                    a.result->target_hit ? "hit" : "missed", a.result->total,
                    static_cast<unsigned long long>(a.result->score_version),
                    static_cast<unsigned long long>(a.result->ticks));
        for (const MetricRow& m : a.result->metrics)
            printLine(fmt::format("    {:<36} {:>12} {:<8} {:5.1f} of {:.1f} points", m.name,
                                  shownNumber(m.value), m.unit, m.points, m.max_points));
    }
    for (const EventRow& e : a.events)
        printLine(fmt::format("    {:9.3f} s  {:<10} {}", double(e.tick) * a.info.dt_s, e.kind, e.text));
    printLine("  " + a.folder.string());
    reportAlteredRows({a});
    return 0;
}

int recoverStore(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const std::vector<std::string> damage = store.damage();
    for (const std::string& line : damage)
        printLine("damaged: " + line);
    for (const StoredAttempt& attempt : store.attempts())
        if (attempt.imported) printLine("imported, not recorded by this store: " + attempt.id);
    for (const std::filesystem::path& folder : store.unknownFolders())
        printLine("not in the index: " + folder.string());
    std::printf("%zu cut short found now, %zu damaged, %zu waiting for the training centre\n",
                store.recovered().size(), damage.size(), store.outbox().size());
    return damage.empty() ? 0 : 1;
}

int exportStore(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const ExportResult exported = exportAttempts(store, options.trainee, options.out);
    for (const std::string& line : exported.damage)
        printLine("damaged: " + line);
    for (const std::string& id : exported.left_out)
        printLine("left out, still being written: " + id);
    std::printf("%zu attempt%s in %s\n", exported.attempts, plural(exported.attempts), options.out.c_str());
    return exported.damage.empty() ? 0 : 1;
}

int discardAttempt(const RecordsOptions& options) {
    Store store = openExistingStore(options.store);
    store.discard(options.id);
    std::printf("attempt %s discarded, and noted in the store's log: see \"stylet records log\"\n",
                options.id.c_str());
    return 0;
}

int printLog(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const std::vector<LogEntry> entries = store.log();
    for (const LogEntry& entry : entries)
        printLine(entry.utc + "  " + entry.text);
    std::printf("%zu attempt%s discarded\n", entries.size(), plural(entries.size()));
    return 0;
}

int deleteTrainee(const RecordsOptions& options) {
    Store store = openExistingStore(options.store);
    const std::size_t count = store.eraseTrainee(options.trainee);
    std::printf(
        "%zu attempt%s of %s deleted; the next \"stylet records sync\" deletes them at the training centre\n",
        count, plural(count), options.trainee.c_str());
    return 0;
}

int syncStore(const RecordsOptions& options) {
    Store store = openExistingStore(options.store);
    const SendReport report = sendOutbox(store, options.database);
    std::printf("%zu sent, %zu deleted there, %zu left\n", report.sent, report.erased, report.left);
    if (!report.error.empty()) reportLine(report.error);
    return report.left == 0 ? 0 : 1;
}

}  // namespace stylet::records
