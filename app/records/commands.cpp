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

void reportAlteredRows(const std::vector<StoredAttempt>& attempts) {
    for (const std::string& line : findAlteredRows(attempts))
        std::fprintf(stderr, "stylet: %s\n", line.c_str());
}

}  // namespace

Store openExistingStore(const std::filesystem::path& folder, const char* program) {
    // The index alone may be lost: the store fills it again.
    if (!std::filesystem::exists(folder / "store.sqlite") && !std::filesystem::exists(folder / "attempts"))
        throw DataError(folder, "store", "does not exist; \"stylet run --trainee ID\" creates it");
    Store store(folder);
    for (const std::string& line : store.openingMessages())
        std::fprintf(stderr, "%s: %s\n", program, line.c_str());
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
        std::printf("%-25s  %-16s  %-*s  %-16s  %-8s  ", a.id.c_str(), a.info.trainee.c_str(), width,
                    std::string(stateText(a)).c_str(), a.info.scenario.c_str(), a.info.difficulty.c_str());
        if (a.result)
            std::printf("%-6s  %5.1f\n", a.result->target_hit ? "hit" : "missed", a.result->total);
        else
            std::printf("%-6s  %5s\n", "-", "-");
    }
    std::printf("%zu attempt%s\n", attempts.size(), plural(attempts.size()));
    reportAlteredRows(attempts);
    return 0;
}

int showAttempt(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const StoredAttempt a = store.attempt(options.id);
    std::printf("attempt %s of %s, %s\n", a.id.c_str(), a.info.trainee.c_str(),
                std::string(stateText(a)).c_str());
    std::printf("  started %s; %s, seed %llu; scenario %s, %s; device %s, gain %.3f; program %s\n",
                a.started_utc.c_str(), a.info.patient.c_str(), static_cast<unsigned long long>(a.info.seed),
                a.info.scenario.c_str(), a.info.difficulty.c_str(), a.info.device.c_str(), a.info.device_gain,
                a.info.program_version.c_str());
    if (a.info.registration_rms_m)
        std::printf("  registration error %.2f mm (root mean square)\n", *a.info.registration_rms_m * 1000.0);
    if (a.result) {
        std::printf("  target %s, score %.1f (score table %llu), %llu ticks\n",
                    a.result->target_hit ? "hit" : "missed", a.result->total,
                    static_cast<unsigned long long>(a.result->score_version),
                    static_cast<unsigned long long>(a.result->ticks));
        for (const MetricRow& m : a.result->metrics)
            std::fputs(fmt::format("    {:<36} {:>12} {:<8} {:5.1f} of {:.1f} points\n", m.name,
                                   shownNumber(m.value), m.unit, m.points, m.max_points)
                           .c_str(),
                       stdout);
    }
    for (const EventRow& e : a.events)
        std::printf("    %9.3f s  %-10s %s\n", double(e.tick) * a.info.dt_s, e.kind.c_str(), e.text.c_str());
    std::printf("  %s\n", a.folder.c_str());
    reportAlteredRows({a});
    return 0;
}

int recoverStore(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const std::vector<std::string> damage = store.damage();
    for (const std::string& line : damage)
        std::printf("damaged: %s\n", line.c_str());
    for (const StoredAttempt& attempt : store.attempts())
        if (attempt.imported) std::printf("imported, not recorded by this store: %s\n", attempt.id.c_str());
    for (const std::filesystem::path& folder : store.unknownFolders())
        std::printf("not in the index: %s\n", folder.c_str());
    std::printf("%zu cut short found now, %zu damaged, %zu waiting for the training centre\n",
                store.recovered().size(), damage.size(), store.outbox().size());
    return damage.empty() ? 0 : 1;
}

int exportStore(const RecordsOptions& options) {
    const Store store = openExistingStore(options.store);
    const ExportResult exported = exportAttempts(store, options.trainee, options.out);
    for (const std::string& line : exported.damage)
        std::printf("damaged: %s\n", line.c_str());
    for (const std::string& id : exported.left_out)
        std::printf("left out, still being written: %s\n", id.c_str());
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
        std::printf("%s  %s\n", entry.utc.c_str(), entry.text.c_str());
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
    if (!report.error.empty()) std::fprintf(stderr, "stylet: %s\n", report.error.c_str());
    return report.left == 0 ? 0 : 1;
}

}  // namespace stylet::records
