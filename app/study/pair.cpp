#include "app/study/pair.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/fields.h"
#include "base/path.h"
#include "base/whole_file.h"

namespace stylet::study {

using patient::Package;

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr std::size_t kMaxPairs = 1000;
constexpr double kGridTolerance_m = 1e-6;
constexpr std::int16_t kOutsideBody_hu = -1024;  // the value that a build writes outside the body

PairFiles readPair(Fields& in) {
    const auto folder = [&](const char* key) {
        return (in.file().parent_path() / in.nonEmptyText(key)).lexically_normal();
    };
    PairFiles pair{"", folder("reference"), folder("found")};
    pair.name = in.textOr("name", withoutSlash(pair.reference).filename().string());
    if (!isPairName(pair.name)) in.refuse("name", "cannot be a folder's name");
    in.finish();
    return pair;
}

// ---- one CT

Vec3 offsetInVoxels(const PairFiles& files, const Grid& reference, const Grid& found) {
    const Vec3 a = reference.spacing_m, b = found.spacing_m;
    if (!glm::all(glm::lessThan(glm::abs(a - b), Vec3(kGridTolerance_m))))
        throw DataError(files.found / "ct.nii.gz", "spacing",
                        fmt::format("voxels of {:.3f} x {:.3f} x {:.3f} mm, the reference's are of {:.3f} x "
                                    "{:.3f} x {:.3f} mm: build it with --spacing-mm of those",
                                    1e3 * b.x, 1e3 * b.y, 1e3 * b.z, 1e3 * a.x, 1e3 * a.y, 1e3 * a.z));
    const Vec3 offset = reference.toVoxels(found.origin_m), whole = glm::round(offset);
    if (!glm::all(glm::lessThan(glm::abs(offset), Vec3(2.0 * kMaxVoxelsPerSide))))
        throw DataError(
            files.found / "ct.nii.gz", "origin",
            "lies far from " + (files.reference / "ct.nii.gz").string() + ": it was built from another CT");
    if (!glm::all(glm::lessThan(glm::abs(offset - whole) * a, Vec3(kGridTolerance_m))))
        throw DataError(files.found / "ct.nii.gz", "origin",
                        "its voxels lie between those of " + (files.reference / "ct.nii.gz").string());
    return whole;
}

// Moves the found package onto the reference's grid. Voxels outside its former grid become air without
// labels.
void moveToReferenceGrid(const PairFiles& files, const CtVolume& reference, Package& found) {
    const Index3 offset(offsetInVoxels(files, reference.grid, found.ct.grid));
    CtVolume ct(reference.grid, kOutsideBody_hu);
    LabelVolume labels(reference.grid);
    std::size_t body = 0, others = 0;
    forEachVoxel(found.ct.grid, [&](const Index3& from) {
        const Index3 to = from + offset;
        const bool inside = reference.grid.contains(to);
        const std::int16_t hu = found.ct[from];
        if (hu != kOutsideBody_hu) {
            ++body;
            others += !inside || reference[to] != hu;
        }
        if (!inside) return;
        ct[to] = hu;
        labels[to] = found.labels[from];
    });
    if (others > 0 || body == 0)
        throw DataError(files.found / "ct.nii.gz", "voxels",
                        fmt::format("{:.1f} % of its voxels in the body are not those of {}: build it from "
                                    "that file, not from another CT or cut",
                                    body ? 100.0 * double(others) / double(body) : 100.0,
                                    (files.reference / "ct.nii.gz").string()));
    found.ct = std::move(ct);
    found.labels = std::move(labels);
}

// ---- independent labels

void checkIndependentLabels(const PairFiles& files, const Package& reference, const Package& found) {
    for (const patient::Label& theirs : found.label_table)
        for (const patient::Label& own : reference.label_table)
            if (!theirs.provenance.empty() && theirs.provenance == own.provenance)
                throw DataError(files.found / "patient.toml", "label." + theirs.name + ".provenance",
                                "\"" + theirs.provenance + "\" is also the provenance of the reference's " +
                                    own.name + ": make the two segmentations independently of each other");
    if (std::find(found.atlases.begin(), found.atlases.end(), reference.name) != found.atlases.end())
        throw DataError(files.found / "patient.toml", "atlases",
                        reference.name + " was one of its atlases: build it again with other atlases");
}

}  // namespace

bool isPairName(const std::string& name) {
    return !name.empty() && name.front() != '.' && name.find('/') == std::string::npos && name.size() < 200 &&
           name != "summary.json" && name != "report.html";
}

StudyFile readStudyFile(const fs::path& file) {
    return parseStudyFile(readWholeFile(file, kMaxFileBytes), file);
}

StudyFile parseStudyFile(std::string_view text, const fs::path& file) {
    Fields in = parseToml(file, text);
    StudyFile study;
    if (in.has("tissue")) study.tissue = file.parent_path() / in.nonEmptyText("tissue");
    std::set<std::string> names;
    for (Fields& pair : in.childrenOrNone("pair", kMaxPairs)) {
        study.pairs.push_back(readPair(pair));
        if (!names.insert(study.pairs.back().name).second)
            pair.refuse("name", "\"" + study.pairs.back().name + "\" is the name of an earlier pair");
    }
    if (study.pairs.empty()) in.refuse("pair", "a study needs at least one [[pair]]");
    in.finish();
    return study;
}

Pair makePair(const PairFiles& files, Package reference, Package found, FoundLabels labels,
              const patient::TissueTable* own_table) {
    Pair pair;
    pair.name = files.name;
    pair.labels = labels;
    pair.reference_share = patient::segmentedShare(reference);
    moveToReferenceGrid(files, reference.ct, found);
    checkIndependentLabels(files, reference, found);
    pair.reference_digest = patient::digest(reference);
    if (own_table) reference.tissues = *own_table;
    // The build's crop to the body also removes the partial-volume rim, which the thresholds classify as
    // skin.
    if (labels == FoundLabels::partial) found.ct = reference.ct;
    found.tissues = reference.tissues;
    found.motion = reference.motion;
    found.signal = reference.signal;
    pair.reference = std::move(reference);
    pair.found = std::move(found);
    return pair;
}

Pair loadPair(const PairFiles& files, FoundLabels labels, const patient::TissueTable* own_table,
              bool accept_implausible) {
    std::vector<std::string> implausible;
    const auto load = [&](const fs::path& folder, const char* role) {
        Package package = patient::loadPackage(folder);
        const std::string note = patient::requirePlausible(package, folder, accept_implausible);
        if (!note.empty() && note != patient::kNotChecked)
            implausible.push_back(std::string(role) + ", " + note);
        return package;
    };
    Package reference = load(files.reference, "reference"), found = load(files.found, "built patient");
    Pair pair = makePair(files, std::move(reference), std::move(found), labels, own_table);
    pair.implausible = std::move(implausible);
    return pair;
}

PreparedPair::PreparedPair(const Pair& p)
    : pair(p),
      full(p.reference),
      partial(p.labels == FoundLabels::all ? patient::Patient(p.found)
                                           : patient::Patient(p.found, &patient::isInPartialSegmentation)),
      full_map(full),
      partial_map(partial) {}

}  // namespace stylet::study
