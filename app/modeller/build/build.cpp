#include "app/modeller/build/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <map>

#include "app/modeller/build/stage_store.h"
#include "app/modeller/build/stages.h"
#include "app/modeller/import.h"
#include "app/modeller/section.h"
#include "patient/nifti.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::CtVolume;
using patient::Index3;
using patient::Label;
using patient::LabelVolume;
using patient::Package;

namespace {

constexpr double kAboveLiver_m = 0.060, kBelowLiver_m = 0.060;

std::uint64_t digestOf(const CtVolume& ct) {
    patient::StateHash hash;
    hash.add(voxelDigest(ct));
    hash.add(ct.grid.spacing_m), hash.add(ct.grid.origin_m);
    return hash.value();
}

// What a stage's result depends on: all before it, its own rules, the settings.
std::uint64_t keyOf(std::uint64_t before, const Stage& stage, const BuildSettings& settings) {
    patient::StateHash hash;
    hash.add(before);
    hash.add(stage.name);
    hash.add(std::uint64_t(stage.version));
    hash.add(std::uint64_t(settings.virtual_ducts));
    for (const fs::path& atlas : settings.atlases)
        hash.add(std::string_view(atlas.native()));
    return hash.value();
}

std::uint64_t chained(std::uint64_t before, const StageResult& result) {
    patient::StateHash hash;
    hash.add(before);
    hash.add(digestOf(result));
    return hash.value();
}

// Runs one stage, or takes what an earlier run or a person left.
StageReport runStage(Work& work, const StageStore& store, int number, const Stage& stage,
                     std::uint64_t& chain) {
    const std::uint64_t key = keyOf(chain, stage, *work.settings);
    const std::string text_name(stage.text_name);
    StageReport report;
    report.name = stage.name;
    std::optional<StageResult> result = store.load(number, stage.name, work.ct.grid, text_name);
    report.kept = result && !result->text_edited && (result->record.corrected || result->record.key == key);
    if (!report.kept) {
        StageResult fresh;
        fresh.record.corrected = result && result->text_edited;
        if (fresh.record.corrected) fresh.text = result->text;
        const auto begin = std::chrono::steady_clock::now();
        stage.find(work, fresh);
        fresh.record.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
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
    work.corrected[report.name] = report.corrected;
    return report;
}

// The scan on the working grid, as far as its body goes.
void readScan(Work& work) {
    const BuildSettings& s = *work.settings;
    const CtVolume scan = readImage(s.ct, ImageKind::ct, s.reader, s.series);
    requireHounsfield(scan, s.ct);
    const double low_m = scan.grid.origin_m.z, high_m = scan.grid.centre(scan.grid.dims - 1).z;
    work.ct = resampleCt(scan, sectionGrid(scan.grid, low_m, high_m, work.settings->spacing_m));
    work.scan = scan.grid;
    work.scan_voxels = voxelDigest(scan);
    LabelVolume none(work.ct.grid);
    work.body = cutToBody(work.ct, none);
}

std::string provenanceOf(const Label& l, const Work& work) {
    for (const Stage& stage : stages()) {
        if (std::find(stage.gives.begin(), stage.gives.end(), l.name) == stage.gives.end()) continue;
        const std::string name(stage.name);
        if (work.corrected.at(name)) return "manual: corrected in stage " + name;
        if (l.name == "bile ducts" && work.virtual_ducts) return "virtual: grown beside the portal branches";
        return "automatic: stage " + name;
    }
    return "automatic";
}

// All stages' labels in one map, later ones over earlier ones, cut to the heights around the liver.
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
            for (std::size_t i = 0; i < found.voxels.size(); ++i)
                if (gives[found.voxels[i]] && (stage.over_all || p.labels.voxels[i] == 0))
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
            throw Cancelled("cancelled before " + std::string(stage) +
                            "; the same command goes on from there");
        if (settings.progress) settings.progress(stage, share);
    };
    const double steps = double(stages().size()) + 3.0;
    Built out;
    Work work;
    work.settings = &settings;
    say("read", 0.0);
    readScan(work);
    const StageStore store(settings.stages);
    std::uint64_t chain = digestOf(work.ct);
    store.keepCt(work.ct);
    int number = 0;
    for (const Stage& stage : stages()) {
        say(stage.name, double(++number) / steps);
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
    StageResult result;
    if (std::optional<StageResult> before = store.load(number, name, ct.grid, std::string(stage.text_name)))
        result = std::move(*before);
    result.labels = patient::readNifti<std::uint8_t>(labels);
    if (result.labels.grid.dims != ct.grid.dims)
        throw patient::DataError(labels, "dim", "is not that of " + (folder / "ct.nii.gz").string());
    result.labels.grid = ct.grid;
    std::array<bool, 256> known{};
    known[0] = true;
    for (const Label& l : stageTable())
        known[l.id] = true;
    for (const std::uint8_t id : result.labels.voxels)
        if (!known[id])
            throw patient::DataError(labels, "voxels",
                                     "id " + std::to_string(id) + " is not in the stage's colour table");
    result.record.corrected = true;
    result.record.notes = {"corrected by hand"};
    store.keep(number, name, result, ct, stageTable(), std::string(stage.text_name));
}

}  // namespace stylet::modeller
