#include "app/trainer/run.h"

#include <cstdio>
#include <set>

#include "app/installation.h"
#include "app/trainer/patient_source.h"
#include "app/trainer/platform_linux.h"

namespace stylet::trainer {

using patient::DataError;

namespace {

constexpr const char* kRuntimeVariable = "XR_RUNTIME_JSON";

// The mock runtime's manifest beside this program: in a build tree, or installed.
std::filesystem::path bundledRuntime() {
    const std::filesystem::path lib = programFolder().parent_path() / "lib";
    for (const std::filesystem::path& file : {lib / "xrmock.json", lib / "stylet" / "xrmock.json"})
        if (std::filesystem::exists(file)) return file;
    return {};
}

records::RecordInfo recordInfo(const AttemptFacts& facts, const Scenario& scenario, double gain) {
    records::RecordInfo info;
    info.program_version = STYLET_VERSION;
    info.patient_folder = facts.patient_folder;
    info.patient_name = facts.patient_name;
    info.scenario = facts.scenario;
    info.moments = scenario.moments;
    info.approach_distance_m = scenario.approach_distance_m;
    info.seed = facts.seed;
    info.gain = gain;
    info.path = facts.path;
    return info;
}

std::string scenariosIn(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".toml") names.insert(entry.path().stem().string());
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "" : ", ") + name;
    return list;
}

}  // namespace

std::filesystem::path scenarioFile(const std::string& name) {
    if (name.ends_with(".toml")) return name;
    const std::filesystem::path folder = assetsFolder() / "scenarios", file = folder / (name + ".toml");
    if (std::filesystem::exists(file)) return file;
    throw DataError(folder, "scenario \"" + name + "\"", "not among: " + scenariosIn(folder));
}

std::optional<Pictures> picturesFor(const patient::Patient& patient, const patient::PlannedPath& path,
                                    const RunOptions& options) {
    if (options.fps.value_or(options.fast ? 0.0 : 1.0) <= 0.0) return std::nullopt;
    if (options.headless && environment(kRuntimeVariable).empty()) {
        const std::filesystem::path mock = bundledRuntime();
        if (!mock.empty()) setEnvironment(kRuntimeVariable, mock.string());
    }
    PictureSettings settings;
    settings.assets = assetsFolder();
    settings.capture_folder = options.out;
    settings.validation = options.validation;
    settings.virtual_clock = options.fast;
    std::string why_not;
    auto pictures = openPictures(patient, path, settings, why_not);
    if (!pictures)
        std::fprintf(stderr, "stylet: no pictures: %s; continuing without pictures\n", why_not.c_str());
    return pictures;
}

int run(const RunOptions& options) {
    needFolder(options.out, "--out");
    const Scenario scenario = loadScenario(scenarioFile(options.scenario));
    const OpenedPatient opened = openPatient(
        {options.patient, options.seed, options.spacing_mm / 1000.0, cacheFolder(), assetsFolder()});
    const patient::Patient patient(opened.package);
    // Paths are planned for the breath that a commanded hold ends in: end-exhale.
    const patient::PlannedPath path = bestPath(patient, opened.folder, patient::Surrogate{});
    const Attempt attempt = makeAttempt(patient, scenario, path, options.seed);
    const AttemptFacts facts{opened.package.name,
                             opened.folder,
                             scenario.name,
                             options.seed,
                             options.fast ? "virtual" : "real time",
                             path,
                             attempt.simulation.dt_s};

    auto pictures = picturesFor(patient, path, options);
    records::RecordWriter record(
        options.out / "record", {patient::digest(opened.package), attempt.simulation},
        recordInfo(facts, scenario,
                   haptics::outputGain(attempt.simulation.profile, attempt.simulation.output)));
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, &record);
    const LoopTotals totals =
        options.fast ? runFast(attempt, session, std::move(pictures), options.fps.value_or(0.0), workClock())
                     : runRealTime(attempt, session, std::move(pictures), monotonicClock());
    record.finish();
    if (record.lost())
        std::fprintf(stderr, "stylet: the record ends at tick %llu: the next was lost to a full ring\n",
                     static_cast<unsigned long long>(record.lost()->first - 1));
    writeResults(patient, facts, session.log(), totals, options.out);
    printResults(facts, session.log(), totals, options.out, options.stats);
    return 0;
}

}  // namespace stylet::trainer
