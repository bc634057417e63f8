#include "app/trainer/stores/patient_source.h"

#include <fmt/core.h>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>
#include <random>
#include <string>

#include "app/installation.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/derived.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/cache_file.h"
#include "base/folder_linux.h"
#include "base/hash.h"
#include "base/whole_file.h"
#include "patient/synth/synth.h"

namespace stylet::trainer {

using patient::PlannedPath;

namespace {

// Reports progress on stderr. On a terminal it counts up in one line. In a log it prints one short line only.
class Progress {
  public:
    explicit Progress(std::string what) : what_(std::move(what)) { printMessage(what_); }
    ~Progress() {
        if (terminal_ && percent_ >= 0) std::fputs("\r\033[K", stderr);
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void show(std::string_view stage, double fraction) {
        const int percent = int(std::floor(fraction * 100.0));
        if (!terminal_ || percent == percent_) return;
        percent_ = percent;
        std::fprintf(stderr, "\r\033[K  %3d %%  %.*s", percent, int(stage.size()), stage.data());
        std::fflush(stderr);
    }

  private:
    std::string what_;
    bool terminal_ = stderrIsTerminal();
    int percent_ = -1;
};

patient::synth::SynthSettings referenceSettings(const PatientRequest& request) {
    patient::synth::SynthSettings settings;
    settings.seed = request.seed;
    settings.spacing_m = request.spacing_m;
    settings.defaults = patient::loadTissueDefaults(request.assets / "tissue" / "ptcd.toml");
    return settings;
}

// Fingerprint of the generator's output for the seed: the digest of a coarse patient. The computation takes
// 0.3 s.
std::uint64_t markOf(const PatientRequest& request) {
    patient::synth::SynthSettings coarse = referenceSettings(request);
    coarse.spacing_m = 0.005;
    return patient::digest(patient::synth::makeReferencePatient(coarse));
}

constexpr std::size_t kMaxTableBytes = 1 << 20;

// The same fingerprint, read from the cache if an earlier start has stored it.
class KeptMark {
  public:
    explicit KeptMark(const PatientRequest& request)
        : file_(request.cache / "derived" / ("mark-seed" + std::to_string(request.seed))) {
        StateHash table;
        table.add(std::string_view(readWholeFile(request.assets / "tissue" / "ptcd.toml", kMaxTableBytes)));
        key_ = derivedKey({request.seed, table.value()});
        const auto bytes = key_ ? loadDerived(file_, *key_) : std::nullopt;
        known_ = bytes && bytes->size() == sizeof mark_;
        if (known_)
            std::memcpy(&mark_, bytes->data(), sizeof mark_);
        else
            mark_ = markOf(request);
    }
    std::uint64_t value() const { return mark_; }
    bool isMade() const { return !known_; }
    void keep() const {
        if (key_ && !known_) saveDerived(file_, *key_, std::as_bytes(std::span(&mark_, 1)));
    }

  private:
    std::filesystem::path file_;
    std::optional<std::uint64_t> key_;
    bool known_ = false;
    std::uint64_t mark_ = 0;
};

// The folder's name contains the fingerprint, so a change of the generator or the force table never leads to
// an outdated patient.
std::filesystem::path referenceFolder(const PatientRequest& request, std::uint64_t mark) {
    return request.cache / "patients" /
           fmt::format("reference-seed{}-{:g}mm-{:08x}", request.seed, request.spacing_m * 1000.0,
                       mark >> 32);
}

// Deletes unfinished folders of runs that were killed. Recent ones stay, because another run may still be
// writing them.
void clearLeftovers(const std::filesystem::path& folder) {
    constexpr std::chrono::hours kAbandoned{1};
    const std::string name = folder.filename().string();
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder.parent_path(), ignored)) {
        const std::string other = entry.path().filename().string();
        if (!other.starts_with(name + ".") && !other.starts_with("." + name + ".")) continue;
        std::error_code gone;
        const auto written = entry.last_write_time(gone);
        if (!gone && std::filesystem::file_time_type::clock::now() - written > kAbandoned)
            std::filesystem::remove_all(entry.path(), ignored);
    }
}

void makeReference(const PatientRequest& request, const std::filesystem::path& folder) {
    Progress progress("making the reference patient of seed " + std::to_string(request.seed) + " in " +
                      folder.string() + " (once)");
    patient::synth::SynthSettings settings = referenceSettings(request);
    settings.progress = [&](std::string_view stage, double fraction) { progress.show(stage, fraction); };
    // Another run may have generated the same patient in the meantime and may be reading it. In that case the
    // existing folder stays.
    const std::filesystem::path fresh = folder.string() + "." + std::to_string(std::random_device{}());
    patient::savePackage(patient::synth::makeReferencePatient(settings), fresh);
    std::error_code taken;
    std::filesystem::rename(fresh, folder, taken);
    if (taken) std::filesystem::remove_all(fresh);
}

bool canBeRead(const std::filesystem::path& folder) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (!std::ifstream(entry.path())) return false;
    return !error;
}

// Checks the end points of a path. The digest already identifies the patient, but the file may have been
// edited by hand.
bool fits(const patient::Patient& patient, const PlannedPath& path, const patient::Surrogate& breath) {
    const patient::Package& package = patient.package();
    if (!(path.breath == breath) || glm::length(path.target_m - path.entry_m) < 0.001) return false;
    const patient::Label* label = patient.label(package.labels.nearestOr(path.target_reference_m, 0));
    const Vec3 entry = deformedFromReference(package.motion, breath, path.entry_reference_m);
    const Vec3 target = deformedFromReference(package.motion, breath, path.target_reference_m);
    return label && label->role == patient::Role::target && glm::length(entry - path.entry_m) < 0.001 &&
           glm::length(target - path.target_m) < 0.001;
}

// Returns why stored paths cannot be used, or null if they can.
const char* staleBecause(const patient::Patient& patient, const patient::StoredPaths& stored,
                         const patient::Surrogate& breath) {
    if (stored.patient_digest != patient::digest(patient.package())) return "was planned on another patient";
    if (stored.planner_version != patient::kPlannerVersion) return "is of another version of the planner";
    if (stored.paths.empty()) return "has no path";
    if (!fits(patient, stored.paths.front(), breath)) return "does not fit the patient in this breath";
    return nullptr;
}

std::vector<PlannedPath> storedPaths(const patient::Patient& patient, const std::filesystem::path& file,
                                     const patient::Surrogate& breath) {
    if (!std::filesystem::exists(file)) return {};
    try {
        patient::StoredPaths stored = patient::loadPaths(file);
        const char* stale = staleBecause(patient, stored, breath);
        if (!stale) return std::move(stored.paths);
        printMessage(fmt::format("{} {}; planning again", file.string(), stale));
    } catch (const DataError& e) {
        printMessage(fmt::format("{}; planning again", e.what()));
    }
    return {};
}

std::vector<PlannedPath> plan(const patient::Patient& patient, const std::filesystem::path& file,
                              const patient::Surrogate& breath) {
    Progress progress("planning paths");
    patient::PlanSettings settings;
    settings.breath = breath;
    patient::PlanResult result =
        planPaths(patient, settings, [&](double fraction) { progress.show("planning paths", fraction); });
    if (result.paths.empty())
        throw DataError(
            file, "paths",
            fmt::format("the planner found none: of {} candidates {} are blocked, {} too long, {} "
                        "too poor",
                        result.candidates, result.rejected_blocked, result.rejected_long,
                        result.rejected_quality));
    // Write a new file and rename it, because other programs may be planning for the same patient or reading
    // the file.
    const std::filesystem::path fresh = file.string() + "." + std::to_string(std::random_device{}());
    try {
        removeStaleTemporaryFiles(file.parent_path(), file.filename().string());
        patient::savePaths({patient::digest(patient.package()), patient::kPlannerVersion, result.paths},
                           fresh);
        std::filesystem::rename(fresh, file);
    } catch (const std::exception& e) {
        std::error_code ignored;
        std::filesystem::remove(fresh, ignored);
        printMessage(fmt::format("the paths were not cached: {}", e.what()));
    }
    return std::move(result.paths);
}

}  // namespace

std::optional<patient::Package> loadCachedPackage(const std::filesystem::path& folder,
                                                  const LoadPackage& load) {
    if (!std::filesystem::exists(folder)) return std::nullopt;
    std::error_code error;
    std::string load_error;
    const std::filesystem::path aside = folder.string() + "." + std::to_string(std::random_device{}());
    try {
        return load(folder);
    } catch (const DataError& e) {
        load_error = e.what();
        // Another program may be replacing it with a valid one. Before checking the folder, move it aside, so
        // that no other program uses it.
        if (!canBeRead(folder)) {
            if (std::filesystem::exists(folder)) throw;
            return std::nullopt;
        }
        std::filesystem::rename(folder, aside, error);
        if (error && std::filesystem::exists(folder)) throw;
    }
    if (error) return std::nullopt;
    // Set the time to now. Otherwise clearLeftovers() of another program might delete the folder as
    // abandoned.
    std::filesystem::last_write_time(aside, std::filesystem::file_time_type::clock::now(), error);
    try {
        patient::Package sound = load(aside);
        std::filesystem::rename(aside, folder, error);
        // If the rename failed, another program has created a package in the meantime.
        if (error) std::filesystem::remove_all(aside, error);
        return sound;
    } catch (const DataError&) {
        // The folder is part of the cache and can be generated again from its seed, so nothing is lost.
        printMessage(load_error + "; rebuilding the patient");
        std::filesystem::remove_all(aside, error);
        return std::nullopt;
    }
}

OpenedPatient openPatient(const PatientRequest& request) {
    if (!request.folder.empty()) {
        const std::filesystem::path folder = std::filesystem::absolute(request.folder);
        OpenedPatient opened{folder, patient::loadPackage(folder)};
        // A retry opens a reference patient by its folder.
        if (folder.parent_path() == request.cache / "patients") return opened;
        opened.check = patient::requirePlausible(opened.package, folder, request.accept_implausible);
        if (!opened.check.empty())
            printMessage(fmt::format("{}: {}", folder.string(),
                                     opened.check == patient::kNotChecked
                                         ? "this patient has not been checked; run `stylet-model check`"
                                         : opened.check));
        return opened;
    }
    Made made;
    const KeptMark mark(request);
    made.marks = mark.isMade();
    const std::filesystem::path folder = referenceFolder(request, mark.value());
    if (std::optional<patient::Package> kept = loadCachedPackage(folder)) {
        mark.keep();
        return {folder, std::move(*kept), made};
    }
    requireFolder(folder.parent_path(), "the patients' cache (XDG_CACHE_HOME)");
    clearLeftovers(folder);
    makeReference(request, folder);
    mark.keep();
    ++made.patients;
    return {folder, patient::loadPackage(folder), made};
}

OpenedPatient openPatient(const PatientOptions& options) {
    return openPatient(
        // Pictures and films may show any patient.
        {options.folder, options.seed, 1e-3 * options.spacing_mm, cacheFolder(), assetsFolder(), true});
}

std::vector<PlannedPath> goodPaths(const patient::Patient& patient, const std::filesystem::path& folder,
                                   const patient::Surrogate& breath, Made* made) {
    const std::filesystem::path file = folder / "paths.json";
    std::vector<PlannedPath> paths = storedPaths(patient, file, breath);
    if (!paths.empty()) return paths;
    if (made) ++made->plans;
    return plan(patient, file, breath);
}

PlannedPath bestPath(const patient::Patient& patient, const std::filesystem::path& folder,
                     const patient::Surrogate& breath) {
    return goodPaths(patient, folder, breath).front();
}

}  // namespace stylet::trainer
