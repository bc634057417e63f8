#include "app/modeller/segmentation/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include "app/installation.h"
#include "app/modeller/import/import.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/lungs.h"
#include "app/modeller/segmentation/stage_store.h"
#include "app/modeller/segmentation/stages.h"
#include "base/hash.h"
#include "patient/package/nifti.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::Label;
using patient::Package;

namespace {

constexpr const char* kCorrected = "corrected by hand";
constexpr double kAboveLiver_m = 0.060, kBelowLiver_m = 0.060;
// For a long scan: room for a liver 26 cm high, and the margin around it.
constexpr double kMostHeight_m = 0.45, kBelowDome_m = 0.33, kAboveDome_m = 0.10, kLook_m = 0.004;

std::uint64_t ctDigest(const CtVolume& ct) {
    StateHash hash;
    hash.add(voxelDigest(ct));
    hash.add(ct.grid.spacing_m), hash.add(ct.grid.origin_m);
    return hash.value();
}

double secondsSince(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Key of a stage's result: the program, all stages before it, and the settings that it uses.
std::uint64_t keyOf(std::uint64_t before, const Stage& stage, const BuildSettings& settings) {
    StateHash hash;
    hash.add(before);
    hash.add(stage.name);
    if (stage.depends) stage.depends(hash, settings);
    return hash.value();
}

std::uint64_t chained(std::uint64_t before, const StageResult& result) {
    StateHash hash;
    hash.add(before);
    hash.add(digestOf(result));
    return hash.value();
}

// Checks that labels edited by a person contain only ids of the colour table. Adds a note for labels that
// the package does not take from this stage.
void checkCorrected(const fs::path& file, const Stage& stage, const LabelVolume& labels,
                    std::vector<std::string>& notes) {
    std::array<bool, 256> there{};
    for (const std::uint8_t id : labels.voxels)
        there[id] = true;
    for (int id = 1; id < 256; ++id) {
        if (!there[std::size_t(id)]) continue;
        const auto l = std::find_if(stageTable().begin(), stageTable().end(),
                                    [&](const Label& label) { return label.id == id; });
        if (l == stageTable().end())
            throw DataError(file, "voxels",
                            "id " + std::to_string(id) + " is not in the stage's colour table");
        const bool taken = std::find(stage.gives.begin(), stage.gives.end(), l->name) != stage.gives.end();
        if (!stage.gives.empty() && !taken && findTarget(l->name))
            notes.push_back("\"" + l->name + "\" is not taken from this stage");
    }
}

// True if its labels were corrected. An edited text does not count; the stage makes new labels from it.
bool handCorrected(const StageRecord& record) {
    return std::find(record.notes.begin(), record.notes.end(), kCorrected) != record.notes.end();
}

// Runs one stage, or reuses the result of an earlier run or a person's correction.
StageReport runStage(Work& work, const StageStore& store, int number, const Stage& stage,
                     std::uint64_t& chain) {
    const std::uint64_t key = keyOf(chain, stage, *work.settings);
    const std::string text_name(stage.text_name);
    StageReport report;
    report.name = stage.name;
    std::optional<StageResult> result = store.load(number, stage.name, work.ct.grid, text_name);
    if (result && result->text_edited && (result->labels_edited || handCorrected(result->record)))
        throw ImportError((store.folderOf(number, stage.name)).string() + ": both its labels and " +
                          text_name +
                          " were edited by hand; remove the stage's folder, or undo the one or the other");
    report.kept = result && !result->text_edited && (result->record.corrected || result->record.key == key);
    if (!report.kept) {
        StageResult fresh;
        fresh.record.corrected = result && result->text_edited;
        if (fresh.record.corrected) fresh.text = result->text;
        const auto begin = std::chrono::steady_clock::now();
        stage.find(work, fresh);
        fresh.record.seconds = secondsSince(begin);
        fresh.record.key = key;
        store.keep(number, stage.name, fresh, work.ct, stageTable(), text_name);
        result = std::move(fresh);
    }
    work.found[report.name] = result->labels;
    if (stage.take) stage.take(work, *result);
    chain = chained(chain, *result);
    report.seconds = result->record.seconds;
    report.corrected = result->record.corrected;
    report.notes = result->record.notes;
    if (report.corrected)
        checkCorrected(store.folderOf(number, stage.name) / "labels.nii.gz", stage, result->labels,
                       report.notes);
    work.corrected[report.name] = report.corrected;
    return report;
}

// The range of heights to process. All of a scan of the upper abdomen; in a longer scan, the region around
// the domes of the lungs' bases, because the liver is below them.
std::pair<double, double> heightsOf(const CtVolume& scan) {
    double low_m = scan.grid.origin_m.z, high_m = scan.grid.centre(scan.grid.dims - 1).z;
    if (high_m - low_m <= kMostHeight_m) return {low_m, high_m};
    CtVolume coarse = resampleCt(scan, sectionGrid(scan.grid, low_m, high_m, kLook_m));
    LabelVolume none(coarse.grid);
    const Mask body = cutToBody(coarse, none);
    double dome_m = -1e9;
    for (const float z : findLungs(coarse, body).base_right.z_m)
        if (std::isfinite(z)) dome_m = std::max(dome_m, double(z));
    if (dome_m < low_m)
        throw ImportError("the scan is " + std::to_string(int(1e3 * (high_m - low_m))) +
                          " mm high and shows no right lung to find the liver by; cut it to the upper belly");
    return {std::max(low_m, dome_m - kBelowDome_m), std::min(high_m, dome_m + kAboveDome_m)};
}

// Reads the scan, resamples it to the working grid and crops it to the body.
void readScan(Work& work) {
    const BuildSettings& s = *work.settings;
    const CtVolume scan = readImage(s.ct, ImageKind::ct, s.reader, s.series);
    requireHounsfield(scan, s.ct);
    const auto [low_m, high_m] = heightsOf(scan);
    const Grid grid = sectionGrid(scan.grid, low_m, high_m, s.spacing_m);
    checkFits(grid);
    work.ct = resampleCt(scan, grid);
    work.scan = scan.grid;
    work.scan_voxels = voxelDigest(scan);
    LabelVolume none(work.ct.grid);
    work.body = cutToBody(work.ct, none);
}

// Stores the CT of the stages. Refuses a new CT if a stage was corrected on another one.
void keepScan(const Work& work, const StageStore& store) {
    const fs::path file = store.folder() / "ct.nii.gz";
    if (fs::exists(file)) {
        if (voxelDigest(patient::readNifti<std::int16_t>(file)) == voxelDigest(work.ct)) return;
        int number = 0;
        for (const Stage& stage : stages()) {
            const auto kept = store.load(++number, stage.name, work.ct.grid, std::string(stage.text_name));
            if (kept && kept->record.corrected)
                throw ImportError(store.folderOf(number, stage.name).string() +
                                  ": was corrected by hand on another CT than this one; build into another "
                                  "folder of stages, or remove it");
        }
    }
    store.keepCt(work.ct);
}

std::string provenanceOf(const Label& l, const Work& work) {
    for (const Stage& stage : stages()) {
        if (std::find(stage.gives.begin(), stage.gives.end(), l.name) == stage.gives.end()) continue;
        const std::string name(stage.name);
        const bool corrected = work.corrected.at(name);
        if (l.name == "bile ducts" && work.virtual_ducts)
            return std::string("virtual: grown beside the portal branches") +
                   (corrected ? ", corrected by hand" : "");
        return corrected ? "manual: corrected in stage " + name : "automatic: stage " + name;
    }
    return "automatic";
}

// Merges all stages' labels, later ones over earlier ones, and crops to the heights around the liver.
Package packageOf(const Work& work) {
    const BuildSettings& settings = *work.settings;
    Package p;
    p.ct = work.painted_ct.voxels.empty() ? work.ct : work.painted_ct;
    p.labels = LabelVolume(work.ct.grid);
    for (const Stage& stage : stages())
        if (!stage.gives.empty()) {
            std::array<bool, 256> gives{};
            for (const std::string& name : stage.gives)
                gives[findTarget(name)->id] = true;
            const LabelVolume& found = work.found.at(std::string(stage.name));
            const bool over_all = stage.over_all || work.corrected.at(std::string(stage.name));
            for (std::size_t i = 0; i < found.voxels.size(); ++i)
                if (gives[found.voxels[i]] && (over_all || p.labels.voxels[i] == 0))
                    p.labels.voxels[i] = found.voxels[i];
        }
    const Mask liver = maskOf(p.labels, [](const Label& l) { return l.tissue == patient::Tissue::liver; });
    const std::size_t slice = std::size_t(p.ct.grid.dims.x) * std::size_t(p.ct.grid.dims.y);
    int low = p.ct.grid.dims.z, high = -1;
    for (std::size_t i = 0; i < liver.voxels.size(); ++i)
        if (liver.voxels[i]) low = std::min(low, int(i / slice)), high = std::max(high, int(i / slice));
    if (high < 0) throw ImportError("no liver was found; without a liver there is nothing to puncture");
    const Index3 last = p.ct.grid.dims - 1;
    const auto steps = [&](double m) { return int(std::ceil(m / p.ct.grid.spacing_m.z)); };
    const Index3 from{0, 0, std::max(0, low - steps(kBelowLiver_m))},
        to{last.x, last.y, std::min(last.z, high + steps(kAboveLiver_m))};
    cropTo(p.ct, from, to);
    cropTo(p.labels, from, to);
    checkFits(p.ct.grid);

    std::array<bool, 256> used{};
    for (const std::uint8_t id : p.labels.voxels)
        used[id] = true;
    for (Label l : targetTable()) {
        if (!used[l.id]) continue;
        l.provenance = provenanceOf(l, work);
        p.label_table.push_back(l);
    }
    p.name = settings.name;
    p.licence = settings.licence;
    p.provenance = "built by stylet-model from a CT alone" + work.atlas_provenance +
                   std::string(work.virtual_ducts ? "; virtual bile ducts added" : "");
    p.thresholds = work.thresholds;
    p.tissues = settings.defaults.tissues;
    p.elasticity = settings.defaults.elasticity;
    p.reference_phase = settings.reference_phase;
    p.motion = patient::motionTemplate(p.labels, p.label_table, {},
                                       {referenceBreath(settings.reference_phase), 0.0});
    return p;
}

}  // namespace

std::vector<std::string> stageNames() {
    std::vector<std::string> names;
    for (const Stage& stage : stages())
        names.emplace_back(stage.name);
    return names;
}

Built build(const BuildSettings& settings) {
    if (!(settings.spacing_m >= 0.0005 && settings.spacing_m <= 0.004))
        throw ImportError("spacing must lie between 0.5 and 4 mm");
    referenceBreath(settings.reference_phase);
    const auto say = [&](std::string_view stage, double share) {
        if (settings.cancelled && settings.cancelled())
            throw std::runtime_error("cancelled before " + std::string(stage) +
                                     "; the same command resumes from there");
        if (settings.progress) settings.progress(stage, share);
    };
    const double steps = double(stages().size()) + 3.0;
    Built out;
    Work work;
    work.settings = &settings;
    say("read", 0.0);
    for (const Stage& stage : stages()) {  // report missing files before any work is done
        StateHash none;
        if (stage.depends) stage.depends(none, settings);
    }
    const auto begin = std::chrono::steady_clock::now();
    readScan(work);
    const StageStore store(settings.stages);
    keepScan(work, store);
    out.stages.push_back({.name = "read", .seconds = secondsSince(begin), .notes = {}});
    StateHash start;
    start.add(ctDigest(work.ct));
    start.add(fileDigest(programFile()));
    std::uint64_t chain = start.value();
    int number = 0;
    for (const Stage& stage : stages()) {
        const double share = double(++number) / steps;
        say(stage.name, share);
        work.say = [&](const std::string& what) {
            if (settings.progress) settings.progress(std::string(stage.name) + ": " + what, share);
        };
        out.stages.push_back(runStage(work, store, number, stage, chain));
    }
    say("package", (steps - 2.0) / steps);
    out.package = packageOf(work);
    say("check", (steps - 1.0) / steps);
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
    if (stage.gives.empty() && stage.text_name != "")
        throw ImportError("the labels of \"" + name + "\" only show its values; edit " +
                          (store.folderOf(number, name) / stage.text_name).string() + " instead");
    StageResult result;
    if (std::optional<StageResult> before = store.load(number, name, ct.grid, std::string(stage.text_name)))
        result = std::move(*before);
    result.labels = patient::readNifti<std::uint8_t>(labels);
    if (result.labels.grid.dims != ct.grid.dims)
        throw DataError(labels, "dim", "is not that of " + (folder / "ct.nii.gz").string());
    result.labels.grid = ct.grid;
    std::vector<std::string> notes;
    checkCorrected(labels, stage, result.labels, notes);
    result.record.corrected = true;
    if (!handCorrected(result.record)) result.record.notes.push_back(kCorrected);
    store.keep(number, name, result, ct, stageTable(), std::string(stage.text_name));
}

}  // namespace stylet::modeller
