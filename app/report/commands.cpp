#include "app/report/commands.h"

#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <memory>

#include "app/report/attempt_page.h"
#include "app/report/group_pages.h"

namespace stylet::report {

using records::StoredAttempt;
namespace fs = std::filesystem;

namespace {

// The default folder in which `stylet run --trainee` keeps attempts.
fs::path usualRecords() {
    const char* data = std::getenv("XDG_DATA_HOME");
    if (data && data[0] == '/') return fs::path(data) / "stylet" / "records";
    const char* home = std::getenv("HOME");
    if (!home || home[0] != '/') throw DataError("records", "folder", "is unknown: pass it with --records");
    return fs::path(home) / ".local" / "share" / "stylet" / "records";
}

// Checks that the store exists, because opening would create it. Opening also repairs attempts that were
// cut short and reports them only once, so they are printed here.
records::Store openStore(const ReportOptions& o) {
    const fs::path folder = o.records.empty() ? usualRecords() : o.records;
    if (!fs::exists(folder / "store.sqlite"))
        throw DataError(folder, "store.sqlite", "not found: this folder has no attempts");
    records::Store store(folder);
    for (const records::Recovered& cut : store.recovered())
        std::fprintf(stderr, "stylet-report: %s\n", records::describe(cut).c_str());
    return store;
}

bool isFolder(const std::string& text) {
    return fs::is_directory(text);
}

void makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw DataError(folder, "folder", error.message());
}

// Removes files of an earlier report that this one may not overwrite.
void removeStale(const fs::path& folder, std::initializer_list<const char*> names) {
    for (const char* name : names) {
        std::error_code error;
        fs::remove(folder / name, error);
        if (error) throw DataError(folder / name, "file", error.message());
    }
}

AttemptFiles openAttempt(const std::string& what, const ReportOptions& o) {
    return isFolder(what) ? readFolder(what) : readAttempt(openStore(o).attempt(what));
}

struct OpenPatient {
    patient::Package package;
    patient::Patient ready{package};
};

// Opens the attempt's patient, if it is still in its folder and unchanged.
std::unique_ptr<OpenPatient> openPatient(AttemptFiles& a, const fs::path& named) {
    const fs::path folder = !named.empty() ? named : a.record ? a.record->patient_folder : fs::path();
    if (!named.empty() && !a.record)
        throw DataError(named, "patient", "is of no use: the attempt has no record that names its path");
    if (folder.empty() || !a.record) return nullptr;
    try {
        if (a.stored.info.patient_digest == 0)
            throw DataError(folder, "patient", "cannot be identified: the attempt's record is incomplete");
        patient::Package package = patient::loadPackage(folder);
        if (patient::digest(package) != a.stored.info.patient_digest)
            throw DataError(folder, "patient", "is not the one that the attempt was made on");
        return std::unique_ptr<OpenPatient>(new OpenPatient{std::move(package)});
    } catch (const DataError& e) {
        if (!named.empty()) throw;
        a.complaints.emplace_back(std::string(e.what()) +
                                  " (no reference curve, and slices as drawn at the time)");
        return nullptr;
    }
}

std::vector<StoredAttempt> atScenario(std::vector<StoredAttempt> attempts, const std::string& scenario) {
    if (!scenario.empty())
        std::erase_if(attempts, [&](const StoredAttempt& a) { return a.info.scenario != scenario; });
    return attempts;
}

}  // namespace

fs::path reportAttempt(const ReportOptions& o) {
    AttemptFiles attempt;
    AttemptContext context;
    if (isFolder(o.attempt)) {
        attempt = readFolder(o.attempt);
    } else {
        const records::Store store = openStore(o);
        attempt = readAttempt(store.attempt(o.attempt));
        context.cohort = atScenario(store.attempts(), attempt.stored.info.scenario);
    }
    const std::unique_ptr<OpenPatient> patient = openPatient(attempt, o.patient);
    if (patient) context.patient = &patient->ready;
    if (!o.reference.empty()) {
        const AttemptFiles reference = openAttempt(o.reference, o);
        if (reference.course.empty()) throw DataError(o.reference, "reference", "has no curve");
        context.references.push_back(curveOf(reference));
    }
    makeFolder(o.out);
    const AttemptReport report = attemptReport(attempt, context);
    removeStale(o.out, {"metrics.csv", "xapi.json"});
    writeText(report.html, o.out / "attempt.html");
    writeCsv(report.course, o.out / "course.csv");
    writeCsv(report.events, o.out / "events.csv");
    if (!report.metrics.rows.empty()) writeCsv(report.metrics, o.out / "metrics.csv");
    if (!attempt.stored.info.trainee.empty())
        writeText(xapiStatements({attempt.stored}, o.xapi), o.out / "xapi.json");
    return o.out / "attempt.html";
}

fs::path reportTrainee(const ReportOptions& o) {
    records::checkTrainee(o.trainee);
    const records::Store store = openStore(o);
    const std::vector<StoredAttempt> attempts = atScenario(store.attempts(o.trainee), o.scenario);
    if (attempts.empty()) throw DataError("trainee", o.trainee, "has no such attempts in these records");
    makeFolder(o.out);
    const GroupReport report = traineeReport(o.trainee, attempts, atScenario(store.attempts(), o.scenario));
    writeText(report.html, o.out / "trainee.html");
    writeCsv(report.attempts, o.out / "attempts.csv");
    writeText(xapiStatements(attempts, o.xapi), o.out / "xapi.json");
    return o.out / "trainee.html";
}

fs::path reportCohort(const ReportOptions& o) {
    const records::Store store = openStore(o);
    const std::vector<StoredAttempt> attempts = atScenario(store.attempts(), o.scenario);
    makeFolder(o.out);
    const GroupReport report =
        cohortReport(o.scenario.empty() ? "All scenarios" : "Scenario " + o.scenario, attempts);
    writeText(report.html, o.out / "cohort.html");
    writeCsv(report.attempts, o.out / "attempts.csv");
    writeText(xapiStatements(attempts, o.xapi), o.out / "xapi.json");
    return o.out / "cohort.html";
}

}  // namespace stylet::report
