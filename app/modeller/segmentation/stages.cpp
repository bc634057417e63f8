#include "app/modeller/segmentation/stages.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "app/modeller/import/import_body.h"
#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/segmentation/bones.h"
#include "app/modeller/segmentation/classes.h"
#include "app/modeller/segmentation/ducts.h"
#include "app/modeller/segmentation/fascia_spline.h"
#include "app/modeller/segmentation/liver.h"
#include "app/modeller/segmentation/lungs.h"
#include "app/modeller/segmentation/morphology.h"
#include "app/modeller/segmentation/organs.h"
#include "app/modeller/segmentation/vessels.h"
#include "base/hash.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

using patient::Label;

namespace {

// Ids used only by stages, in addition to a package's labels.
constexpr std::uint8_t kAirways = 253, kBody = 254;
constexpr double kSkin_m = 0.002, kBlur_m = 0.002;
constexpr std::size_t kLongestList = 1800;  // a package's provenance has at most 2000 characters
constexpr double kAtlasSpacing_m = 0.0025;  // the prior's grid is coarser
constexpr const char* kControlPoints = "control-points.txt";
constexpr const char* kVirtualDucts = "these ducts are virtual: bile is painted into the CT";

std::uint8_t idOf(const char* target) {
    return findTarget(target)->id;
}

Mask maskOfId(const LabelVolume& labels, std::uint8_t id) {
    Mask mask(labels.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = labels.voxels[i] == id;
    return mask;
}

std::vector<Vec3> centresOfSlices(const Mask& mask) {
    const Grid& g = mask.grid;
    std::vector<Vec3> centres;
    for (int z = 0; z < g.dims.z; ++z) {
        Vec3 sum{0.0};
        double count = 0.0;
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                if (mask[{x, y, z}]) sum += g.centre({x, y, z}), count += 1.0;
        if (count > 0.0) centres.push_back(sum / count);
    }
    return centres;
}

// Stage "body": the part of the scan that is neither air nor table, as found when the scan was read.
void findBody(Work& work, StageResult& r) {
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, work.body, kBody, true);
}
void takeBody(Work& work, const StageResult& r) {
    for (std::size_t i = 0; i < work.body.voxels.size(); ++i)
        work.body.voxels[i] = r.labels.voxels[i] != 0;
}

// Stage "classes": the tissue values of this CT, and the labels that the thresholds alone would give.
void findClasses(Work& work, StageResult& r) {
    if (r.text.empty()) {
        const TissueClasses c = classesOf(work.ct, work.body);
        r.text = writeClasses(c, thresholdsOf(c));
        if (c.blood.share == 0.0) r.record.notes.push_back("no contrast medium is to be seen");
    }
    const patient::Thresholds t = parseClasses(r.text);
    r.labels = LabelVolume(work.ct.grid);
    const std::uint8_t skin = idOf("skin"), soft = idOf("muscle"), bone = idOf("bone");
    for (std::size_t i = 0; i < r.labels.voxels.size(); ++i) {
        const double hu = work.ct.voxels[i];
        if (!work.body.voxels[i] || hu < t.t0_hu) continue;
        r.labels.voxels[i] = hu < t.t1_hu ? skin : hu < t.t2_sensitive_hu ? soft : bone;
    }
}
void takeClasses(Work& work, const StageResult& r) {
    work.thresholds = parseClasses(r.text);
}

void findLungsStage(Work& work, StageResult& r) {
    const Lungs lungs = findLungs(work.ct, work.body);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, lungs.gas, idOf("bowel gas"), true);
    paint(r.labels, lungs.airways, kAirways, true);
    paint(r.labels, lungs.right, idOf("right lung"), true);
    paint(r.labels, lungs.left, idOf("left lung"), true);
    r.record.notes = lungs.notes;
}

// "right ribs: 6 (12 ml), 7 (14 ml)"
std::string ribsOf(const Bones& bones, bool right) {
    std::string all;
    for (const Rib& rib : bones.ribs) {
        if (rib.right != right) continue;
        char text[32];
        std::snprintf(text, sizeof text, "%d (%.0f ml)", rib.number, rib.volume_ml);
        all += (all.empty() ? (right ? "right ribs: " : "left ribs: ") : ", ") + std::string(text);
    }
    return all;
}

// Soft tissue next to a bone that blur lifts above the threshold. Without a label it would stop a needle.
// Voxels surrounded by bright voxels are excluded, because they are missed bone.
Mask blurredRim(const Work& work, const Mask& bones) {
    const double reach_m = std::max(kBlur_m, 1.01 * work.ct.grid.spacing_m.x);
    Mask bright = bones;
    for (std::size_t i = 0; i < bright.voxels.size(); ++i)
        bright.voxels[i] =
            bones.voxels[i] || (work.body.voxels[i] && work.ct.voxels[i] >= work.thresholds.t2_sensitive_hu);
    const Mask rim = both(without(dilated(bones, reach_m), bones), bright);
    return without(rim, eroded(closed(bright, reach_m), reach_m));
}

void findBonesStage(Work& work, StageResult& r) {
    const Bones bones = findBones(work.ct, work.body);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, bones.other, idOf("bone"), true);
    paint(r.labels, bones.cartilage, idOf("cartilage and discs"), true);
    paint(r.labels, bones.spine, idOf("spine"), true);
    paint(r.labels, bones.canal, idOf("spinal canal"), true);
    paint(r.labels, bones.sternum, idOf("sternum"), true);
    paint(r.labels, bones.ribs_right, idOf("right ribs"), true);
    paint(r.labels, bones.ribs_left, idOf("left ribs"), true);
    paint(r.labels, blurredRim(work, bones.all), idOf("muscle"), false);
    r.record.notes = bones.notes;
    for (const bool right : {true, false})
        if (const std::string ribs = ribsOf(bones, right); !ribs.empty()) r.record.notes.push_back(ribs);
}

bool isBone(const Label& l) {
    return l.tissue == patient::Tissue::bone && l.name != "cartilage and discs";
}
bool isLung(const Label& l) {
    return l.name == "right lung" || l.name == "left lung";
}

bool isSolidOrgan(const Label& l) {
    return l.name == "right kidney" || l.name == "left kidney" || l.name == "spleen" || l.name == "heart" ||
           l.name == "gallbladder";
}

AtlasImage atlasImage(const patient::Package& package, const Work& work, const AtlasSettings& atlas) {
    refuseItself(work.settings->name, atlasList({package.name}));
    if (voxelDigest(package.ct) == work.scan_voxels)
        throw ImportError("atlas \"" + package.name +
                          "\" has the very CT that is to be built from, which proves "
                          "nothing: leave that atlas out");
    return {package, atlas};
}

std::vector<AtlasImage> atlasImages(const Work& work, const AtlasSettings& atlas) {
    const BuildSettings& settings = *work.settings;
    std::vector<AtlasImage> images;
    for (const std::filesystem::path& folder : settings.atlases)
        images.push_back(atlasImage(patient::loadPackage(folder), work, atlas));
    std::vector<std::string> names;
    for (const AtlasImage& image : images)
        names.push_back(image.name);
    if (atlasList(names).size() > kLongestList)
        throw ImportError(
            "the atlases' names are longer than a provenance takes; name fewer, or shorter ones");
    if (!images.empty()) return images;
    for (const std::uint64_t seed : kAtlasSeeds) {
        patient::synth::SynthSettings synth;
        synth.seed = seed;
        synth.spacing_m = kAtlasSpacing_m;
        synth.defaults = settings.defaults;
        images.push_back(atlasImage(patient::synth::makeReferencePatient(synth), work, atlas));
    }
    return images;
}

// Hashes the files of the atlases, independent of folder names.
void hashAtlases(StateHash& hash, const BuildSettings& settings) {
    for (const std::filesystem::path& folder : settings.atlases)
        for (const char* file : {"patient.toml", "ct.nii.gz", "labels.nii.gz"})
            hash.add(fileDigest(folder / file));
    hash.add(fileDigest(childProgram({}, "stylet-register")));
}

void findLiverStage(Work& work, StageResult& r) {
    AtlasSettings atlas;
    atlas.progress = [&](std::string_view name) { work.say(std::string(name)); };
    const Mask lungs = maskOf(work.found.at("lungs"), isLung), bones = maskOf(work.found.at("bones"), isBone);
    const AtlasPrior prior = alignAtlases(work.ct, work.body, lungs, atlasImages(work, atlas), atlas);
    const Liver liver = findLiver(work.ct, work.body, lungs, bones, prior);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, liver.mask, idOf("liver"), true);
    r.record.notes = liver.notes;
    if (const std::string used = atlasList(prior.used); !used.empty()) r.record.notes.push_back(used);
}
void takeLiver(Work& work, const StageResult& r) {
    for (const std::string& note : r.record.notes)
        if (note.starts_with("atlases: ")) {
            refuseItself(work.settings->name, note);
            work.atlas_provenance = "; " + note;
        }
}

void findVesselsStage(Work& work, StageResult& r) {
    const Mask liver = maskOf(work.found.at("liver"), "liver");
    const SplitVessels split = splitVessels(work.ct, liver, findVessels(work.ct, liver));
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, split.cava, idOf("vena cava and renal veins"), true);
    paint(r.labels, split.portal, idOf("portal vein"), true);
    paint(r.labels, split.hepatic, idOf("hepatic veins"), true);
    r.record.notes = split.notes;
}

void hashVirtualDucts(StateHash& hash, const BuildSettings& settings) {
    hash.add(std::uint64_t(settings.virtual_ducts));
}

void findDuctsStage(Work& work, StageResult& r) {
    const LabelVolume& vessels = work.found.at("vessels");
    const Mask liver = maskOf(work.found.at("liver"), "liver"), portal = maskOf(vessels, "portal vein");
    const Mask all = maskOf(vessels, [](const Label& l) { return l.tissue == patient::Tissue::vessel; });
    const BuiltDucts ducts = buildDucts(work.ct, liver, portal, all, work.settings->virtual_ducts);
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, ducts.mask, idOf("bile ducts"), true);
    r.record.notes = {ducts.note};
    if (ducts.origin == DuctsOrigin::grown) r.record.notes.push_back(kVirtualDucts);
}
// Paints virtual ducts into the CT from their labels, so that a person's corrections are painted too.
void takeDucts(Work& work, const StageResult& r) {
    work.virtual_ducts =
        std::find(r.record.notes.begin(), r.record.notes.end(), kVirtualDucts) != r.record.notes.end();
    if (!work.virtual_ducts) return;
    GrownDucts ducts;
    ducts.mask = maskOf(r.labels, "bile ducts");
    FloatVolume share(work.ct.grid);
    for (std::size_t i = 0; i < share.voxels.size(); ++i)
        share.voxels[i] = float(ducts.mask.voxels[i]);
    ducts.coverage = boxMean(share, 1);
    work.painted_ct = work.ct;
    paintBile(work.painted_ct, ducts, maskOf(work.found.at("liver"), "liver"), DuctSettings{}.bile_hu);
}

// Rebuilds the lungs from the label maps of earlier stages, which a person may have corrected.
Lungs lungsOf(const Work& work) {
    const LabelVolume& found = work.found.at("lungs");
    Lungs lungs{maskOf(found, "right lung"),
                maskOf(found, "left lung"),
                maskOfId(found, kAirways),
                maskOf(found, "bowel gas"),
                {},
                {},
                {}};
    lungs.base_right = lungBase(lungs.right, work.body);
    lungs.base_left = lungBase(lungs.left, work.body);
    return lungs;
}
Bones bonesOf(const Work& work) {
    const LabelVolume& found = work.found.at("bones");
    Bones bones;
    bones.all = maskOf(found, isBone);
    bones.spine = maskOf(found, "spine");
    bones.ribs_right = maskOf(found, "right ribs");
    bones.ribs_left = maskOf(found, "left ribs");
    bones.sternum = maskOf(found, "sternum");
    bones.canal = maskOf(found, "spinal canal");
    bones.cartilage = maskOf(found, "cartilage and discs");
    bones.canal_m = centresOfSlices(bones.canal);
    return bones;
}

// Lungs and liver: the only organs inside the fascia that are known before the organ stage.
Mask lungsAndLiver(const Work& work) {
    return either(maskOf(work.found.at("lungs"), isLung), maskOf(work.found.at("liver"), "liver"));
}

void findOrgansStage(Work& work, StageResult& r) {
    const Lungs lungs = lungsOf(work);
    const Bones bones = bonesOf(work);
    const Mask liver = maskOf(work.found.at("liver"), "liver"), known = lungsAndLiver(work);
    const FasciaInput first{work.ct, work.body, bones.all, known};
    const Mask inside = insideFascia(fitFascia(first), first);
    r.labels = LabelVolume(work.ct.grid);
    for (const FoundOrgan& organ : findOrgans({work.ct, work.body, lungs, bones, liver, inside})) {
        paint(r.labels, organ.mask, idOf(organ.name.c_str()), true);
        char confidence[32];
        std::snprintf(confidence, sizeof confidence, ": confidence %.2f", organ.confidence);
        r.record.notes.push_back(organ.name + confidence + (organ.note.empty() ? "" : "; " + organ.note));
    }
}

void findFasciaStage(Work& work, StageResult& r) {
    const Bones bones = bonesOf(work);
    const Mask organs = either(lungsAndLiver(work), maskOf(work.found.at("organs"), isSolidOrgan));
    const FasciaInput input{work.ct, work.body, bones.all, organs};
    if (r.text.empty()) r.text = writeFascia(fitFascia(input));
    const FasciaSpline fascia = parseFascia(kControlPoints, r.text);
    r.labels = LabelVolume(work.ct.grid);
    // Muscle, stomach and spleen overlap cartilage in HU. Inside the fascia there is no costal cartilage.
    const Mask cartilage = costalCartilage(work.ct, work.body, insideFascia(fascia, input), bones);
    paint(r.labels, without(cartilage, organs), idOf("cartilage and discs"), true);
    paint(r.labels, fasciaVoxels(fascia, input), idOf("fascia"), true);
}

void findSkin(Work& work, StageResult& r) {
    r.labels = LabelVolume(work.ct.grid);
    paint(r.labels, skinShell(work.body, work.scan, kSkin_m), idOf("skin"), true);
}

std::vector<Stage> makeStages() {
    return {
        {.name = "body", .find = findBody, .take = takeBody},
        {.name = "classes", .text_name = "classes.json", .find = findClasses, .take = takeClasses},
        {.name = "lungs", .gives = {"right lung", "left lung"}, .find = findLungsStage},
        {.name = "bones",
         .gives = {"right ribs", "left ribs", "spine", "spinal canal", "sternum", "bone",
                   "cartilage and discs", "muscle"},
         .find = findBonesStage},
        {.name = "liver",
         .gives = {"liver"},
         .find = findLiverStage,
         .depends = hashAtlases,
         .take = takeLiver},
        {.name = "vessels", .gives = {"portal vein", "hepatic veins"}, .find = findVesselsStage},
        {.name = "ducts",
         .gives = {"bile ducts"},
         .find = findDuctsStage,
         .depends = hashVirtualDucts,
         .take = takeDucts},
        {.name = "organs",
         .gives = {"right kidney", "left kidney", "spleen", "heart", "aorta and arteries",
                   "vena cava and renal veins", "gallbladder", "stomach and oesophagus", "colon",
                   "bowel gas"},
         .over_all = false,
         .find = findOrgansStage},
        {.name = "fascia",
         .text_name = kControlPoints,
         .gives = {"fascia", "cartilage and discs"},
         .find = findFasciaStage},
        {.name = "skin", .gives = {"skin"}, .over_all = false, .find = findSkin},
    };
}

std::vector<Label> makeTable() {
    std::vector<Label> table = targetTable();
    const auto add = [&](std::uint8_t id, const char* name, std::array<std::uint8_t, 3> colour) {
        Label label;
        label.id = id, label.name = name, label.colour = colour;
        table.push_back(label);
    };
    add(kAirways, "airways", {120, 200, 230});
    add(kBody, "body", {200, 160, 120});
    return table;
}

}  // namespace

std::uint64_t voxelDigest(const CtVolume& ct) {
    StateHash hash;
    for (int axis = 0; axis < 3; ++axis)
        hash.add(std::uint64_t(ct.grid.dims[axis]));
    hash.addBytes(std::as_bytes(std::span(ct.voxels)));
    return hash.value();
}

const std::vector<Stage>& stages() {
    static const std::vector<Stage> all = makeStages();
    return all;
}

const std::vector<Label>& stageTable() {
    static const std::vector<Label> table = makeTable();
    return table;
}

}  // namespace stylet::modeller
