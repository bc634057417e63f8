#include "patient/package/package.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <future>

#include "base/hash.h"
#include "base/path.h"
#include "base/whole_file.h"
#include "patient/package/motion_io.h"
#include "patient/package/nifti.h"
#include "patient/package/package_toml.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTomlName = "patient.toml";
constexpr const char* kCtName = "ct.nii.gz";
constexpr const char* kLabelsName = "labels.nii.gz";
constexpr const char* kMotionName = "motion.nii.gz";
constexpr const char* kColoursName = "labels.ctbl";
constexpr double kVoxelTolerance_m = 1e-6;  // single-precision error of a value in millimetres below 1 m

void checkLabelIds(const fs::path& file, const Package& p) {
    std::array<bool, 256> used{}, known{};
    for (const std::uint8_t id : p.labels.voxels)
        used[id] = true;
    for (const Label& label : p.label_table)
        known[label.id] = true;
    for (std::size_t id = 1; id < 256; ++id)
        if (used[id] && !known[id])
            throw DataError(file, "voxels", fmt::format("id {} has no entry in patient.toml", id));
}

// Flushes to disk, so that the rename that follows cannot reach the disk before the contents.
void flushToDisk(const fs::path& path) {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return;
    fsync(descriptor);
    close(descriptor);
}

// Moves `fresh` to `folder`, which may already exist.
void replaceFolder(const fs::path& fresh, const fs::path& folder) {
    if (rename(fresh.c_str(), folder.c_str()) == 0) return;  // `folder` did not exist or was empty
    if (renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, folder.c_str(), RENAME_EXCHANGE) == 0) {
        fs::remove_all(fresh);  // now contains the old package
        return;
    }
    // On a file system without exchange the old package briefly exists under its temporary name only.
    const fs::path old = fresh.string() + ".old";
    fs::rename(folder, old);
    fs::rename(fresh, folder);
    fs::remove_all(old);
}

void checkBeforeSaving(const Package& p, const fs::path& folder) {
    const fs::path toml = folder / kTomlName;
    checkPackageFolder(folder);
    if (!(p.labels.grid == p.ct.grid)) throw DataError(folder / kLabelsName, "grid", "differs from the CT's");
    if (p.ct.voxels.size() != p.ct.grid.voxelCount() || p.labels.voxels.size() != p.ct.voxels.size())
        throw DataError(folder / kCtName, "voxels", "count does not fit the grid");
    // The loader must accept everything that is written.
    const Package again = parsePackageToml(toml, packageToml(p));
    if (!(again.motion.reference == p.motion.reference))
        throw DataError(toml, "reference_phase", "is not the breath in motion.reference");
    checkMotion(folder / kMotionName, p.motion);
    checkLabelIds(folder / kLabelsName, p);
}

void addTissues(StateHash& hash, const Package& p) {
    for (const TissueRow& row : p.tissues) {
        hash.add(row.cut_force_n), hash.add(row.friction_n), hash.add(row.stiffness_n_per_m);
        hash.add(std::uint64_t(row.membrane)), hash.add(std::uint64_t(row.role));
    }
    for (const Elasticity& e : p.elasticity)
        hash.add(e.young_pa);
    hash.add(p.thresholds.t0_hu), hash.add(p.thresholds.t1_hu);
    hash.add(p.thresholds.t2_sensitive_hu), hash.add(p.thresholds.t2_specific_hu);
}

void addLabels(StateHash& hash, const Package& p) {
    const Patient patient(p);  // finds labels by id, whatever the order of the label table
    for (int id = 1; id < 256; ++id) {
        const Label* label = patient.label(std::uint8_t(id));
        if (!label) continue;
        hash.add(std::uint64_t(id)), hash.add(std::uint64_t(label->tissue));
        hash.add(std::uint64_t(label->role)), hash.add(std::uint64_t(label->abdominal));
        hash.add(std::uint64_t(label->blood)), hash.add(std::uint64_t(label->structure));
        hash.add(std::uint64_t(label->blocks_contrast)), hash.add(std::uint64_t(label->drains_ducts));
        // Hashed only if it is used, so that the digest of an exact patient does not depend on it.
        if (label->border_uncertainty_m > 0.0) hash.add(label->border_uncertainty_m);
    }
}

void addMotion(StateHash& hash, const Package& p) {
    const MotionModel& m = p.motion;
    for (const double x :
         {m.reference.v, m.reference.rate_per_s, m.reference.creep_v, m.v.low, m.v.high, m.rate_per_s.low,
          m.rate_per_s.high, m.dome_travel_m, p.signal.period_s, p.signal.amplitude})
        hash.add(x);
    hash.add(std::uint64_t(m.level_m.size()));
    if (m.empty()) return;
    for (int axis = 0; axis < 3; ++axis)
        hash.add(std::uint64_t(m.grid.dims[axis]));
    hash.add(m.grid.spacing_m), hash.add(m.grid.origin_m);
    static_assert(sizeof(MotionCoefficients) == 6 * sizeof(float));
    hash.addBytes(std::as_bytes(std::span(m.wall)));
    hash.addBytes(std::as_bytes(std::span(m.slide)));
    hash.addBytes(std::as_bytes(std::span(m.level_m)));
}

}  // namespace

std::string colourTable(const std::vector<Label>& labels) {
    std::string text = "# Color table file labels.ctbl\n0 unsegmented 0 0 0 0\n";
    for (const Label& label : labels) {
        std::string name = label.name.empty() ? "unnamed" : label.name;
        std::replace_if(name.begin(), name.end(), [](unsigned char c) { return c <= ' '; }, '_');
        text += fmt::format("{} {} {} {} {} 255\n", label.id, name, label.colour[0], label.colour[1],
                            label.colour[2]);
    }
    return text;
}

TissueDefaults loadTissueDefaults(const fs::path& toml) {
    return parseTissueDefaults(toml, readWholeFile(toml, kMaxTomlBytes));
}

Package loadPackage(const fs::path& folder) {
    const fs::path toml = folder / kTomlName, ct = folder / kCtName, labels = folder / kLabelsName;
    Package p = parsePackageToml(toml, readWholeFile(toml, kMaxTomlBytes));
    const Grid exact = p.ct.grid;
    // Read in parallel: decompressing the CT takes most of the start-up time.
    const bool moves = p.motion.grid.dims.x > 0;
    auto segmented = std::async([&labels] { return readNifti<std::uint8_t>(labels); });
    auto moved = std::async(moves ? std::launch::async | std::launch::deferred : std::launch::deferred,
                            [&] { readMotion(folder / kMotionName, p.motion); });
    p.ct = readNifti<std::int16_t>(ct);
    checkStoredGrid(ct, p.ct.grid, exact, kVoxelTolerance_m);
    p.labels = segmented.get();
    checkStoredGrid(labels, p.labels.grid, exact, kVoxelTolerance_m);
    if (p.labels.grid.dims != p.ct.grid.dims) throw DataError(labels, "dim", "differs from the CT's");
    for (Grid* grid : {&p.ct.grid, &p.labels.grid}) {
        grid->spacing_m = exact.spacing_m;
        grid->origin_m = exact.origin_m;
    }
    checkLabelIds(labels, p);
    if (moves) moved.get();
    return p;
}

void checkPackageFolder(const fs::path& folder) {
    std::error_code error;
    if (!fs::exists(folder, error) || fs::exists(folder / kTomlName, error)) return;
    if (!fs::is_directory(folder, error) || !fs::is_empty(folder, error) || error)
        throw DataError(folder, "folder", "exists and is not a patient package");
}

void savePackage(const Package& p, const fs::path& folder) {
    const fs::path target = withoutSlash(fs::absolute(folder).lexically_normal());
    checkBeforeSaving(p, target);
    std::error_code error;
    fs::create_directories(target.parent_path(), error);
    if (error) throw DataError(target.parent_path(), "folder", "cannot be made: " + error.message());
    std::string name = target.parent_path() / fmt::format(".{}.XXXXXX", target.filename().string());
    if (!mkdtemp(name.data())) throw DataError(name, "folder", std::strerror(errno));
    const fs::path fresh = name;
    try {
        fs::permissions(fresh, fs::perms(0755));
        writeFile(fresh / kTomlName, packageToml(p));
        writeFile(fresh / kColoursName, colourTable(p.label_table));
        writeNifti(fresh / kCtName, p.ct);
        writeNifti(fresh / kLabelsName, p.labels);
        if (!p.motion.empty()) writeMotion(fresh / kMotionName, p.motion);
        for (const fs::directory_entry& file : fs::directory_iterator(fresh))
            flushToDisk(file.path());
        flushToDisk(fresh);
        replaceFolder(fresh, target);
        flushToDisk(target.parent_path());
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(fresh, ignored);
        throw;
    }
}

std::uint64_t digest(const Package& p) {
    static_assert(std::endian::native == std::endian::little,
                  "bytes of the volumes are hashed as they lie in memory");
    StateHash hash;
    hash.add(std::string_view("stylet patient 5"));
    addTissues(hash, p);
    addLabels(hash, p);
    addMotion(hash, p);
    for (int axis = 0; axis < 3; ++axis)
        hash.add(std::uint64_t(p.ct.grid.dims[axis]));
    hash.add(p.ct.grid.spacing_m), hash.add(p.ct.grid.origin_m);
    hash.addBytes(std::as_bytes(std::span(p.ct.voxels)));
    hash.addBytes(std::as_bytes(std::span(p.labels.voxels)));
    return hash.value();
}

}  // namespace stylet::patient
