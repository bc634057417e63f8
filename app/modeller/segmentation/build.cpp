#include "app/modeller/segmentation/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "app/installation.h"
#include "app/modeller/check/check_scan.h"
#include "app/modeller/image/morphology.h"
#include "app/modeller/image/scan_blur.h"
#include "app/modeller/import/import.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/segmentation/lungs.h"
#include "app/modeller/segmentation/orientation.h"
#include "app/modeller/segmentation/stage_store.h"
#include "app/modeller/segmentation/stages.h"
#include "base/hash.h"
#include "patient/package/nifti.h"
#include "patient/package/origin.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::Label;
using patient::Package;

namespace {

constexpr double kAboveLiver_m = 0.060, kBelowLiver_m = 0.060;
// For a long scan: room for a liver 26 cm high, and the margin around it.
constexpr double kMaxHeight_m = 0.45, kBelowDome_m = 0.33, kAboveDome_m = 0.10, kPreviewSpacing_m = 0.004;

std::uint64_t ctDigest(const CtVolume& ct) {
    StateHash hash;
    hash.add(voxelDigest(ct));
    hash.add(ct.grid.spacing_m), hash.add(ct.grid.origin_m);
    return hash.value();
}

double secondsSince(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Computes the key of a stage's result from the program, all stages before it, and the settings that it uses.
std::uint64_t stageKey(std::uint64_t before, const Stage& stage, const BuildSettings& settings) {
    StateHash hash;
    hash.add(before);
    hash.add(stage.name);
    if (stage.hash_inputs) stage.hash_inputs(hash, settings);
    return hash.value();
}

std::uint64_t extendChain(std::uint64_t before, const StageResult& result) {
    StateHash hash;
    hash.add(before);
    hash.add(resultDigest(result));
    return hash.value();
}

// Checks that labels edited by a person contain only ids of the colour table. Adds a note if the package does
// not use some of these labels from this stage.
void checkCorrected(const fs::path& file, const Stage& stage, const LabelVolume& labels,
                    std::vector<std::string>& notes) {
    std::array<bool, 256> present{};
    for (const std::uint8_t id : labels.voxels)
        present[id] = true;
    for (int id = 1; id < 256; ++id) {
        if (!present[std::size_t(id)]) continue;
        const auto l = std::find_if(stageTable().begin(), stageTable().end(),
                                    [&](const Label& label) { return label.id == id; });
        if (l == stageTable().end())
            throw DataError(file, "voxels",
                            "id " + std::to_string(id) + " is not in the stage's colour table");
        const bool taken =
            std::find(stage.provides.begin(), stage.provides.end(), l->name) != stage.provides.end();
        if (!stage.provides.empty() && !taken && findTarget(l->name))
            notes.push_back("\"" + l->name + "\" is not taken from this stage");
    }
}

// Labels computed from a text that a person edited are all corrected.
std::array<bool, 256> findCorrected(const StageResult& result, std::vector<std::string>& notes) {
    std::array<bool, 256> corrected{};
    if (!result.record.corrected) return corrected;
    if (!result.labels_edited && !result.record.labels_replaced) {
        corrected.fill(true);
        return corrected;
    }
    if (!result.changed) notes.push_back("automatic.nii.gz is missing: all labels count as not corrected");
    return result.changed.value_or(corrected);
}

// Runs one stage, or reuses the result of an earlier run or a person's correction.
StageReport runStage(BuildState& work, const StageStore& store, int number, const Stage& stage,
                     std::uint64_t& chain) {
    const std::uint64_t key = stageKey(chain, stage, *work.settings);
    const std::string text_name(stage.text_name);
    StageReport report;
    report.name = stage.name;
    std::optional<StageResult> result = store.load(number, stage.name, work.ct.grid, text_name);
    if (result && result->text_edited && (result->labels_edited || result->record.labels_replaced))
        throw ImportError((store.stageFolder(number, stage.name)).string() + ": both its labels and " +
                          text_name +
                          " were edited by hand; remove the stage's folder, or undo the one or the other");
    report.reused = result && !result->text_edited && (result->record.corrected || result->record.key == key);
    if (!report.reused) {
        StageResult fresh;
        fresh.record.corrected = result && result->text_edited;
        if (fresh.record.corrected) fresh.text = result->text;
        fresh.labels = LabelVolume(work.ct.grid);
        const auto begin = std::chrono::steady_clock::now();
        stage.find(work, fresh);
        fresh.record.seconds = secondsSince(begin);
        fresh.record.key = key;
        store.save(number, stage.name, fresh, work.ct, stageTable(), text_name);
        result = std::move(fresh);
    }
    work.found[report.name] = result->labels;
    if (stage.restore) stage.restore(work, *result);
    chain = extendChain(chain, *result);
    report.seconds = result->record.seconds;
    report.corrected = result->record.corrected;
    report.notes = result->record.notes;
    if (!result->record.atlases.empty())
        report.notes.push_back(patient::formatAtlasList(result->record.atlases));
    if (report.corrected)
        checkCorrected(store.stageFolder(number, stage.name) / "labels.nii.gz", stage, result->labels,
                       report.notes);
    work.corrected[report.name] = report.corrected;
    work.corrected_labels[report.name] = findCorrected(*result, report.notes);
    return report;
}

// Returns the range of heights to process. A scan of the upper abdomen is processed entirely. In a longer
// scan, it is the region around the lung bases, because the liver is below them.
std::pair<double, double> findHeightRange(const CtVolume& scan, const BuildSettings& settings) {
    double low_m = scan.grid.origin_m.z, high_m = scan.grid.centre(scan.grid.dims - 1).z;
    if (high_m - low_m <= kMaxHeight_m) return {low_m, high_m};
    CtVolume coarse = resampleCt(scan, sectionGrid(scan.grid, low_m, high_m, kPreviewSpacing_m, settings.ct));
    LabelVolume none(coarse.grid);
    std::vector<std::string> notes;  // not kept: the section itself is cropped later
    const Mask body = cropToBody(coarse, none, settings.ct, notes);
    const Lungs lungs = findLungs(coarse, body);
    if (!settings.trust_axes) checkUpright(body, unite(lungs.right, lungs.left), settings.ct);
    double dome_m = -1e9;
    for (const float z : lungs.base_right.z_m)
        if (std::isfinite(z)) dome_m = std::max(dome_m, double(z));
    if (dome_m < low_m)
        throw ImportError(settings.ct.string() + ": size: the scan is " +
                          std::to_string(int(1e3 * (high_m - low_m))) +
                          " mm high and shows no right lung to find the liver by; cut it to the upper belly");
    return {std::max(low_m, dome_m - kBelowDome_m), std::min(high_m, dome_m + kAboveDome_m)};
}

// Reads the scan, resamples it to the working grid and crops it to the body.
void readScan(BuildState& work) {
    const BuildSettings& s = *work.settings;
    const CtVolume scan = readImage(s.ct, ImageKind::ct, s.reader, s.series);
    requireHounsfield(scan, s.ct);
    const auto [low_m, high_m] = findHeightRange(scan, s);
    const Grid grid = sectionGrid(scan.grid, low_m, high_m, s.spacing_m, s.ct);
    checkPackageSize(grid);
    work.ct = resampleCt(scan, grid);
    work.scan = scan.grid;
    work.scan_voxels = voxelDigest(scan);
    work.blur = measureBlur(work.ct);
    LabelVolume none(work.ct.grid);
    work.body = cropToBody(work.ct, none, s.ct, work.body_notes);
}

// Stores the CT of the stages. Refuses a new CT if a stage was corrected on another one.
void storeScan(const BuildState& work, const StageStore& store) {
    const fs::path file = store.folder() / "ct.nii.gz";
    if (fs::exists(file)) {
        if (voxelDigest(patient::readNifti<std::int16_t>(file)) == voxelDigest(work.ct)) return;
        int number = 0;
        for (const Stage& stage : stages()) {
            const auto kept = store.load(++number, stage.name, work.ct.grid, std::string(stage.text_name));
            if (kept && kept->record.corrected)
                throw ImportError(store.stageFolder(number, stage.name).string() +
                                  ": was corrected by hand on another CT than this one; build into another "
                                  "folder of stages, or remove it");
        }
    }
    store.saveCt(work.ct);
}

bool isCorrected(const Label& l, const Stage& stage, const BuildState& work) {
    return work.corrected_labels.at(std::string(stage.name))[l.id];
}

// Two stages may provide a label; then a correction in either of them is named.
std::string labelProvenance(const Label& l, const BuildState& work) {
    std::string automatic = "automatic";
    for (const Stage& stage : stages()) {
        if (std::find(stage.provides.begin(), stage.provides.end(), l.name) == stage.provides.end()) continue;
        const std::string name(stage.name);
        const bool corrected = isCorrected(l, stage, work);
        if (l.name == "bile ducts" && work.virtual_ducts)
            return std::string("virtual: grown beside the portal branches") +
                   (corrected ? ", corrected by hand" : "");
        if (corrected) return "manual: corrected in stage " + name;
        if (automatic == "automatic") automatic += ": stage " + name;
    }
    return automatic;
}

// How far the true border may lie outside a risk structure found by a stage (Label::border_uncertainty_m). On
// seed 5 at 1 mm, 13.3 % of the planned paths cross a true risk structure without this distance, 5.5 % with
// 1.5 mm, 2.5 % with 2 mm and 2.5 % with 3 mm, which leaves fewer paths.
constexpr double kBorder_m = 0.002;

// At least a voxel. The border of a label is exact if a person corrected it in every stage that provides it.
double borderUncertainty(const Label& l, const BuildState& work) {
    if (l.role == patient::Role::suspect) return work.ct.grid.spacing_m.x;
    if (l.role != patient::Role::risk) return 0.0;
    const bool found = std::any_of(stages().begin(), stages().end(), [&](const Stage& s) {
        return std::find(s.provides.begin(), s.provides.end(), l.name) != s.provides.end() &&
               !isCorrected(l, s, work);
    });
    return found ? std::max(kBorder_m, work.ct.grid.spacing_m.x) : 0.0;
}

// Merges all stages' labels, later ones over earlier ones, and crops to the heights around the liver.
Package makePackage(const BuildState& work) {
    const BuildSettings& settings = *work.settings;
    Package p;
    p.ct = work.painted_ct.voxels.empty() ? work.ct : work.painted_ct;
    p.labels = LabelVolume(work.ct.grid);
    for (const Stage& stage : stages())
        if (!stage.provides.empty()) {
            std::array<bool, 256> provides{};
            for (const std::string& name : stage.provides)
                provides[findTarget(name)->id] = true;
            const LabelVolume& found = work.found.at(std::string(stage.name));
            const bool over_all = stage.over_all || work.corrected.at(std::string(stage.name));
            for (std::size_t i = 0; i < found.voxels.size(); ++i)
                if (provides[found.voxels[i]] && (over_all || p.labels.voxels[i] == 0))
                    p.labels.voxels[i] = found.voxels[i];
        }
    const Mask liver = labelMask(p.labels, [](const Label& l) { return l.tissue == patient::Tissue::liver; });
    const VoxelBox box = boundingBox(liver);
    if (box.empty())
        throw ImportError(settings.ct.string() +
                          ": voxels: no liver was found; without a liver there is nothing to puncture");
    const Index3 last = p.ct.grid.dims - 1;
    const auto steps = [&](double m) { return int(std::ceil(m / p.ct.grid.spacing_m.z)); };
    const VoxelBox section{{0, 0, std::max(0, box.low.z - steps(kBelowLiver_m))},
                           {last.x, last.y, std::min(last.z, box.high.z + steps(kAboveLiver_m))}};
    p.ct = cropped(p.ct, section);
    p.labels = cropped(p.labels, section);
    checkPackageSize(p.ct.grid);

    fillLabelTable(p, [&](const Label& l) { return labelProvenance(l, work); });
    for (Label& l : p.label_table)
        l.border_uncertainty_m = borderUncertainty(l, work);
    p.name = settings.name;
    p.licence = settings.licence;
    p.provenance = "built by stylet-model from a CT alone";
    if (work.virtual_ducts) p.provenance += "; virtual bile ducts added";
    if (settings.trust_axes) p.provenance += "; the axes of the scan were trusted, not checked";
    p.atlases = work.atlases;
    p.thresholds = work.thresholds;
    p.tissues = settings.defaults.tissues;
    p.elasticity = settings.defaults.elasticity;
    p.reference_phase = settings.reference_phase;
    p.scan.slice_m = sliceDistance(work.scan);
    if (!work.blur.within_assumed) p.scan.blur_within_m = work.blur.within_m;
    p.motion = patient::motionTemplate(p.labels, p.label_table, {},
                                       {parseReferencePhase(settings.reference_phase), 0.0});
    return p;
}

}  // namespace

std::vector<std::string> stageNames() {
    std::vector<std::string> names;
    for (const Stage& stage : stages())
        names.emplace_back(stage.name);
    return names;
}

BuildResult build(const BuildSettings& settings) {
    if (!(settings.spacing_m >= 0.0005 && settings.spacing_m <= 0.004))
        throw ImportError("spacing must lie between 0.5 and 4 mm");
    parseReferencePhase(settings.reference_phase);
    const auto reportProgress = [&](std::string_view stage, double share) {
        if (settings.cancelled && settings.cancelled())
            throw std::runtime_error("cancelled before " + std::string(stage) +
                                     "; the same command resumes from there");
        if (settings.progress) settings.progress(stage, share);
    };
    const double steps = double(stages().size()) + 3.0;
    BuildResult out;
    BuildState work;
    work.settings = &settings;
    reportProgress("read", 0.0);
    for (const Stage& stage : stages()) {  // report missing files before any work is done
        StateHash none;
        if (stage.hash_inputs) stage.hash_inputs(none, settings);
    }
    const auto begin = std::chrono::steady_clock::now();
    readScan(work);
    const StageStore store(settings.stages);
    storeScan(work, store);
    out.stages.push_back({.name = "read", .seconds = secondsSince(begin), .notes = {}});
    StateHash start;
    start.add(ctDigest(work.ct));
    start.add(work.blur.within_m), start.add(work.blur.across_m);
    start.add(fileDigest(programFile()));
    std::uint64_t chain = start.value();
    int number = 0;
    for (const Stage& stage : stages()) {
        const double share = double(++number) / steps;
        reportProgress(stage.name, share);
        work.progress = [&](const std::string& what) {
            if (settings.progress) settings.progress(std::string(stage.name) + ": " + what, share);
        };
        out.stages.push_back(runStage(work, store, number, stage, chain));
    }
    reportProgress("package", (steps - 2.0) / steps);
    out.package = makePackage(work);
    reportProgress("check", (steps - 1.0) / steps);
    out.findings = checkPackage(out.package);
    if (settings.progress) settings.progress("done", 1.0);
    return out;
}

void correctStage(const fs::path& folder, const std::string& name, const fs::path& labels) {
    const std::vector<std::string> names = stageNames();
    const auto it = std::find(names.begin(), names.end(), name);
    if (it == names.end()) {
        std::string all;
        for (const std::string& n : names)
            all += (all.empty() ? "" : ", ") + n;
        throw ImportError("\"" + name + "\" is no stage; they are " + all);
    }
    if (!fs::exists(folder / "ct.nii.gz"))
        throw ImportError(folder.string() + ": holds no stages yet; build once before you correct");
    const int number = int(it - names.begin()) + 1;
    const StageStore store(folder);
    const CtVolume ct = patient::readNifti<std::int16_t>(folder / "ct.nii.gz");
    const Stage& stage = stages()[std::size_t(number - 1)];
    if (stage.provides.empty() && stage.text_name != "")
        throw ImportError("the labels of \"" + name + "\" only show its values; edit " +
                          (store.stageFolder(number, name) / stage.text_name).string() + " instead");
    StageResult result;
    const std::optional<StageResult> before = store.load(number, name, ct.grid, std::string(stage.text_name));
    if (before) result = *before;
    result.labels = patient::readNifti<std::uint8_t>(labels);
    if (result.labels.grid.dims != ct.grid.dims)
        throw DataError(labels, "dim", "is not that of " + (folder / "ct.nii.gz").string());
    result.labels.grid = ct.grid;
    std::vector<std::string> notes;
    checkCorrected(labels, stage, result.labels, notes);
    if (!before) {  // the program found none: all labels are the person's
        StageResult empty;
        empty.labels = LabelVolume(ct.grid);
        store.save(number, name, empty, ct, stageTable(), std::string(stage.text_name));
    }
    result.record.corrected = true;
    if (!result.record.labels_replaced) result.record.notes.push_back("corrected by hand");
    result.record.labels_replaced = true;
    store.save(number, name, result, ct, stageTable(), std::string(stage.text_name));
}

}  // namespace stylet::modeller
