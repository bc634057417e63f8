#include "app/study/pair.h"

#include <toml++/toml.h>
#include <cmath>
#include <cstdio>
#include <set>

#include "base/whole_file.h"

namespace stylet::study {

using patient::Package;

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr std::size_t kMaxPairs = 1000;
constexpr double kSamePlace_m = 1e-6;
constexpr std::int16_t kOutsideBody_hu = -1024;  // the value that a build writes outside the body

std::string nameOf(std::size_t pair) {
    return "pair[" + std::to_string(pair) + "]";
}

std::string textOf(const fs::path& file, const std::string& field,
                   const toml::node_view<const toml::node>& node) {
    const std::optional<std::string> value = node.value<std::string>();
    if (!value || value->empty()) throw DataError(file, field, "a text is needed");
    return *value;
}

void allowOnly(const fs::path& file, const std::string& where, const toml::table& table,
               const std::set<std::string_view>& keys) {
    for (const auto& [key, node] : table)
        if (!keys.contains(key.str())) throw DataError(file, where + std::string(key.str()), "no such field");
}

PairFiles readPair(const fs::path& file, const toml::node& node, std::size_t index) {
    const std::string where = nameOf(index);
    const toml::table* table = node.as_table();
    if (!table) throw DataError(file, where, "not a table");
    allowOnly(file, where + ".", *table, {"name", "reference", "found"});
    const auto member = [&](const char* key) {
        return textOf(file, where + "." + key, toml::node_view<const toml::node>(table->get(key)));
    };
    const auto folder = [&](const char* key) {
        return (file.parent_path() / member(key)).lexically_normal();
    };
    PairFiles pair{"", folder("reference"), folder("found")};
    const fs::path last = pair.reference.has_filename() ? pair.reference : pair.reference.parent_path();
    pair.name = table->contains("name") ? member("name") : last.filename().string();
    if (!isPairName(pair.name)) throw DataError(file, where + ".name", "cannot be a folder's name");
    return pair;
}

// ---- one CT

Vec3 offsetInVoxels(const PairFiles& files, const Grid& reference, const Grid& found) {
    const Vec3 a = reference.spacing_m, b = found.spacing_m;
    if (!glm::all(glm::lessThan(glm::abs(a - b), Vec3(kSamePlace_m)))) {
        char reason[200];
        std::snprintf(
            reason, sizeof reason,
            "voxels of %.3f x %.3f x %.3f mm, the reference's are of %.3f x %.3f x %.3f mm: build it "
            "with --spacing-mm of those",
            1e3 * b.x, 1e3 * b.y, 1e3 * b.z, 1e3 * a.x, 1e3 * a.y, 1e3 * a.z);
        throw DataError(files.found / "ct.nii.gz", "spacing", reason);
    }
    const Vec3 offset = reference.toVoxels(found.origin_m), whole = glm::round(offset);
    if (!glm::all(glm::lessThan(glm::abs(offset), Vec3(2.0 * kMaxVoxelsASide))))
        throw DataError(files.found / "ct.nii.gz", "origin",
                        "far from " + (files.reference / "ct.nii.gz").string() + ": another CT");
    if (!glm::all(glm::lessThan(glm::abs(offset - whole) * a, Vec3(kSamePlace_m))))
        throw DataError(files.found / "ct.nii.gz", "origin",
                        "its voxels lie between those of " + (files.reference / "ct.nii.gz").string());
    return whole;
}

// Moves the found package onto the reference's grid. Outside its own grid it is air without labels.
void moveTo(const PairFiles& files, const CtVolume& reference, Package& found) {
    const Index3 offset(offsetInVoxels(files, reference.grid, found.ct.grid));
    CtVolume ct(reference.grid, kOutsideBody_hu);
    LabelVolume labels(reference.grid);
    std::size_t body = 0, others = 0;
    const Index3 dims = found.ct.grid.dims;
    std::size_t from = 0;
    for (int z = 0; z < dims.z; ++z)
        for (int y = 0; y < dims.y; ++y)
            for (int x = 0; x < dims.x; ++x, ++from) {
                const Index3 to = Index3(x, y, z) + offset;
                const bool inside = reference.grid.contains(to);
                const std::int16_t hu = found.ct.voxels[from];
                if (hu != kOutsideBody_hu) {
                    ++body;
                    others += !inside || reference[to] != hu;
                }
                if (!inside) continue;
                ct[to] = hu;
                labels[to] = found.labels.voxels[from];
            }
    if (others > 0 || body == 0) {
        char reason[160];
        std::snprintf(reason, sizeof reason, "%.1f %% of its voxels in the body are not those of ",
                      body ? 100.0 * double(others) / double(body) : 100.0);
        throw DataError(files.found / "ct.nii.gz", "voxels",
                        reason + (files.reference / "ct.nii.gz").string() +
                            ": build it from that file, not from another CT or cut");
    }
    found.ct = std::move(ct);
    found.labels = std::move(labels);
}

// ---- independent labels

void refuseShared(const PairFiles& files, const Package& reference, const Package& found) {
    for (const patient::Label& theirs : found.label_table)
        for (const patient::Label& own : reference.label_table)
            if (!theirs.provenance.empty() && theirs.provenance == own.provenance)
                throw DataError(files.found / "patient.toml", "label." + theirs.name + ".provenance",
                                "\"" + theirs.provenance + "\" is that of the reference's " + own.name +
                                    ": labels that were not made apart prove nothing");
    if (found.provenance.find('"' + reference.name + '"') != std::string::npos)
        throw DataError(files.found / "patient.toml", "provenance",
                        reference.name + " is among the atlases that it was built with");
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
    toml::table table;
    try {
        table = toml::parse(text);
    } catch (const toml::parse_error& e) {
        throw DataError(file, "line " + std::to_string(e.source().begin.line), std::string(e.description()));
    }
    allowOnly(file, "", table, {"tissue", "pair"});
    StudyFile study;
    if (const toml::node* tissue = table.get("tissue"))
        study.tissue = file.parent_path() / textOf(file, "tissue", toml::node_view<const toml::node>(tissue));
    const toml::array* pairs = table["pair"].as_array();
    if (!pairs || pairs->empty()) throw DataError(file, "pair", "a study needs one [[pair]] at least");
    if (pairs->size() > kMaxPairs) throw DataError(file, "pair", "more than 1000 of them");
    std::set<std::string> names;
    for (std::size_t i = 0; i < pairs->size(); ++i) {
        study.pairs.push_back(readPair(file, *pairs->get(i), i));
        if (!names.insert(study.pairs.back().name).second)
            throw DataError(file, nameOf(i) + ".name",
                            "\"" + study.pairs.back().name + "\" is there already");
    }
    return study;
}

Pair makePair(const PairFiles& files, Package reference, Package found, FoundLabels labels,
              const patient::TissueTable* own_table) {
    Pair pair;
    pair.name = files.name;
    pair.labels = labels;
    pair.reference_share = patient::segmentedShare(reference);
    moveTo(files, reference.ct, found);
    refuseShared(files, reference, found);
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

Pair loadPair(const PairFiles& files, FoundLabels labels, const patient::TissueTable* own_table) {
    return makePair(files, patient::loadPackage(files.reference), patient::loadPackage(files.found), labels,
                    own_table);
}

PreparedPair::PreparedPair(const Pair& p)
    : pair(p),
      full(p.reference),
      partial(p.labels == FoundLabels::all ? patient::Patient(p.found)
                                           : patient::Patient(p.found, &patient::isInPartialSegmentation)),
      full_map(full),
      partial_map(partial) {}

}  // namespace stylet::study
