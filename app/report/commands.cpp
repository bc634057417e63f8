#include "app/report/commands.h"

#include <cstdlib>
#include <initializer_list>
#include <memory>

#include "app/records/commands.h"
#include "app/report/attempt_page.h"
#include "app/report/group_pages.h"
#include "base/folder_linux.h"
#include "base/whole_file.h"

namespace stylet::report {

using records::StoredAttempt;
namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "stylet-report";  // prefix of messages

// The default folder in which `stylet run --trainee` keeps attempts.
fs::path defaultRecordsFolder() {
    const char* data = std::getenv("XDG_DATA_HOME");
    if (data && data[0] == '/') return fs::path(data) / "stylet" / "records";
    const char* home = std::getenv("HOME");
    if (!home || home[0] != '/') throw DataError("records", "folder", "is unknown: pass it with --records");
    return fs::path(home) / ".local" / "share" / "stylet" / "records";
}

records::Store openStore(const ReportOptions& o) {
    return records::openExistingStore(o.records.empty() ? defaultRecordsFolder() : o.records, kProgram);
}

// Removes files of an earlier report that this one may not overwrite.
void removeStale(const fs::path& folder, std::initializer_list<const char*> names) {
    for (const char* name : names) {
        std::error_code error;
        fs::remove(folder / name, error);
        if (error) throw DataError(folder / name, "file", error.message());
    }
}

// Loads an attempt that the user names by its folder or by its id in the store. Throws DataError if the
// record in the store was changed.
LoadedAttempt loadNamedAttempt(const std::string& what, const ReportOptions& o) {
    if (fs::is_directory(what)) return loadAttempt(what);
    const records::Store store = openStore(o);
    const StoredAttempt attempt = store.attempt(what);
    store.checkRecord(what);
    LoadedAttempt loaded = loadAttempt(attempt.folder);
    loaded.stored.imported |= attempt.imported;  // the mark in its folder may be gone
    return loaded;
}

struct OpenPatient {
    patient::Package package;
    patient::Patient ready{package};
};

// Opens the attempt's patient, if it is still in its folder and unchanged.
std::unique_ptr<OpenPatient> openPatient(LoadedAttempt& a, const fs::path& named) {
    const fs::path folder = named.empty() ? a.record.patient_folder : named;
    try {
        patient::Package package = patient::loadPackage(folder);
        if (patient::digest(package) != a.stored.info.patient_digest)
            throw DataError(folder, "patient", "is not the one that the attempt was made on");
        return std::unique_ptr<OpenPatient>(new OpenPatient{std::move(package)});
    } catch (const DataError& e) {
        if (!named.empty()) throw;
        a.warnings.emplace_back(std::string(e.what()) + " (no reference curve and no slices)");
        return nullptr;
    }
}

std::vector<StoredAttempt> filterByScenario(std::vector<StoredAttempt> attempts,
                                            const std::string& scenario) {
    if (!scenario.empty())
        std::erase_if(attempts, [&](const StoredAttempt& a) { return a.info.scenario != scenario; });
    return attempts;
}

// Writes a page over several attempts, and its files.
fs::path writeGroup(const ReportOptions& o, const char* page, const GroupReport& report,
                    const std::vector<StoredAttempt>& attempts) {
    requireFolder(o.out, "--out");
    writeWholeFile(o.out / page, report.html);
    writeCsv(report.attempts, o.out / "attempts.csv");
    writeWholeFile(o.out / "xapi.json", xapiStatements(attempts, o.xapi));
    return o.out / page;
}

}  // namespace

fs::path reportAttempt(const ReportOptions& o) {
    LoadedAttempt attempt = loadNamedAttempt(o.attempt, o);
    AttemptContext context;
    if (o.cohort) context.cohort = filterByScenario(openStore(o).attempts(), attempt.stored.info.scenario);
    const std::unique_ptr<OpenPatient> patient = openPatient(attempt, o.patient);
    if (patient) context.patient = &patient->ready;
    if (!o.reference.empty()) {
        const LoadedAttempt reference = loadNamedAttempt(o.reference, o);
        if (reference.course.empty()) throw DataError(o.reference, "reference", "has no curve");
        context.references.push_back(insertionCurve(reference));
    }
    requireFolder(o.out, "--out");
    const AttemptReport report = attemptReport(attempt, context);
    removeStale(o.out, {"metrics.csv", "xapi.json"});
    writeWholeFile(o.out / "attempt.html", report.html);
    writeCsv(report.course, o.out / "course.csv");
    writeCsv(report.events, o.out / "events.csv");
    if (!report.metrics.rows.empty()) writeCsv(report.metrics, o.out / "metrics.csv");
    if (!attempt.stored.info.trainee.empty())
        writeWholeFile(o.out / "xapi.json", xapiStatements({attempt.stored}, o.xapi));
    return o.out / "attempt.html";
}

fs::path reportTrainee(const ReportOptions& o) {
    records::checkTrainee(o.trainee);
    const records::Store store = openStore(o);
    const std::vector<StoredAttempt> attempts = filterByScenario(store.attempts(o.trainee), o.scenario);
    if (attempts.empty())
        throw DataError("trainee", o.trainee,
                        "has no such attempts in these records: see \"stylet records list\"");
    const std::vector<StoredAttempt> cohort = filterByScenario(store.attempts(), o.scenario);
    const std::vector<std::string> altered = records::reportAlteredRows(attempts, kProgram);
    return writeGroup(o, "trainee.html", traineeReport(o.trainee, attempts, cohort, altered), attempts);
}

fs::path reportCohort(const ReportOptions& o) {
    const records::Store store = openStore(o);
    const std::vector<StoredAttempt> attempts = filterByScenario(store.attempts(), o.scenario);
    const std::string title = o.scenario.empty() ? "All scenarios" : "Scenario " + o.scenario;
    const std::vector<std::string> altered = records::reportAlteredRows(attempts, kProgram);
    return writeGroup(o, "cohort.html", cohortReport(title, attempts, altered), attempts);
}

}  // namespace stylet::report
