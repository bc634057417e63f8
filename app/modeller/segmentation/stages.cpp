#include "app/modeller/segmentation/stages.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <future>

#include "app/modeller/image/morphology.h"
#include "app/modeller/import/import_body.h"
#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/segmentation/bones.h"
#include "app/modeller/segmentation/classes.h"
#include "app/modeller/segmentation/ducts.h"
#include "app/modeller/segmentation/liver.h"
#include "app/modeller/segmentation/lungs.h"
#include "app/modeller/segmentation/organs.h"
#include "app/modeller/segmentation/orientation.h"
#include "app/modeller/segmentation/vessels.h"
#include "app/modeller/wall/bright_rim.h"
#include "app/modeller/wall/costal_cartilage.h"
#include "app/modeller/wall/fascia_spline.h"
#include "base/hash.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

using patient::Label;

namespace {

// Ids used only by stages, in addition to a package's labels.
constexpr std::uint8_t kAirways = 253, kBody = 254;
constexpr double kSkin_m = 0.002;
// Arteries reach it in their phase. What is denser inside the liver is calcified, or metal.
constexpr std::int16_t kDensestBlood_hu = 400;
constexpr double kAtlasSpacing_m = 0.0025;  // of the default atlases; the prior's grid is coarser
constexpr const char* kControlPoints = "control-points.txt";

// Labels the voxels as a target.
void paintTarget(StageResult& r, const Mask& where, const char* target, bool over_all = true) {
    paint(r.labels, where, targetId(target), over_all);
}

Mask liverMask(const BuildState& work) {
    return labelMask(work.found.at("liver"), "liver");
}

std::vector<Vec3> sliceCentroids(const Mask& mask) {
    const Grid& g = mask.grid;
    std::vector<Vec3> centres;
    for (int z = 0; z < g.dims.z; ++z) {
        Vec3 sum{0.0};
        double count = 0.0;
        forEachVoxel(VoxelBox{{0, 0, z}, {g.dims.x - 1, g.dims.y - 1, z}}, [&](const Index3& i) {
            if (mask[i]) sum += g.centre(i), count += 1.0;
        });
        if (count > 0.0) centres.push_back(sum / count);
    }
    return centres;
}

// Stage "body": the part of the scan that is neither air nor table, as found when the scan was read.
void findBody(BuildState& work, StageResult& r) {
    paint(r.labels, work.body, kBody, true);
    r.record.notes = work.body_notes;
}
void restoreBody(BuildState& work, const StageResult& r) {
    work.body = maskWhere(r.labels.grid, [&](std::size_t i) { return r.labels.voxels[i] != 0; });
}

// Stage "classes": the tissue values of this CT, and the labels that the thresholds alone would give.
void findClasses(BuildState& work, StageResult& r) {
    if (r.text.empty()) {
        const TissueClasses c = estimateTissueClasses(work.ct, work.body);
        r.text = writeClasses(c, computeThresholds(c));
        if (c.blood.share == 0.0) r.record.notes.push_back("no contrast medium is visible");
    }
    r.record.notes.push_back(blurText(work.blur));
    const patient::Thresholds t = parseClasses(r.text);
    const std::uint8_t skin = targetId("skin"), soft = targetId("muscle"), bone = targetId("bone");
    for (std::size_t i = 0; i < r.labels.voxels.size(); ++i) {
        const double hu = work.ct.voxels[i];
        if (!work.body.voxels[i] || hu < t.t0_hu) continue;
        r.labels.voxels[i] = hu < t.t1_hu ? skin : hu < t.t2_sensitive_hu ? soft : bone;
    }
}
void restoreClasses(BuildState& work, const StageResult& r) {
    work.thresholds = parseClasses(r.text);
}

void findLungsStage(BuildState& work, StageResult& r) {
    const Lungs lungs = findLungs(work.ct, work.body);
    paintTarget(r, lungs.gas, "bowel gas");
    paint(r.labels, lungs.airways, kAirways, true);
    paintTarget(r, lungs.right, "right lung");
    paintTarget(r, lungs.left, "left lung");
    r.record.notes = lungs.notes;
}

// "right ribs: 6 (12 ml), 7 (14 ml)"
std::string formatRibs(const Bones& bones, bool right) {
    std::string all;
    for (const Rib& rib : bones.ribs) {
        if (rib.right != right) continue;
        all += fmt::format("{}{} ({:.0f} ml)", all.empty() ? (right ? "right ribs: " : "left ribs: ") : ", ",
                           rib.number, rib.volume_ml);
    }
    return all;
}

void findBonesStage(BuildState& work, StageResult& r) {
    const Bones bones = findBones(work.ct, work.body, work.blur);
    paintTarget(r, bones.other, "bone");
    paintTarget(r, bones.cartilage, "cartilage and discs");
    paintTarget(r, bones.spine, "spine");
    paintTarget(r, bones.canal, "spinal canal");
    paintTarget(r, bones.sternum, "sternum");
    paintTarget(r, bones.ribs_right, "right ribs");
    paintTarget(r, bones.ribs_left, "left ribs");
    const double bone_hu = work.thresholds.t2_sensitive_hu;
    paintTarget(r, brightRim(work.ct, work.body, bones.all, bone_hu, work.blur), "muscle", false);
    r.record.notes = bones.notes;
    for (const bool right : {true, false})
        if (const std::string ribs = formatRibs(bones, right); !ribs.empty()) r.record.notes.push_back(ribs);
}

AtlasImage atlasImage(const patient::Package& package, const BuildState& work, const AtlasSettings& atlas) {
    checkNotOwnAtlas(work.settings->name, {package.name});
    if (voxelDigest(package.ct) == work.scan_voxels)
        throw ImportError(
            "atlas \"" + package.name +
            "\" has the CT that is to be segmented, so the result would prove nothing: leave out "
            "that atlas");
    return {package, atlas};
}

std::vector<AtlasImage> atlasImages(const BuildState& work, const AtlasSettings& atlas) {
    const BuildSettings& settings = *work.settings;
    std::vector<AtlasImage> images;
    for (const std::filesystem::path& folder : settings.atlases)
        images.push_back(atlasImage(patient::loadPackage(folder), work, atlas));
    if (!images.empty()) return images;
    std::vector<std::future<AtlasImage>> made;
    for (const std::uint64_t seed : kAtlasSeeds)
        made.push_back(std::async(std::launch::async, [&, seed] {
            patient::synth::SynthSettings synth;
            synth.seed = seed;
            synth.spacing_m = kAtlasSpacing_m;
            synth.defaults = settings.defaults;
            synth.motion = false;
            synth.threads = 1;  // all are made at once
            return atlasImage(patient::synth::makeReferencePatient(synth), work, atlas);
        }));
    for (std::future<AtlasImage>& image : made)
        images.push_back(image.get());
    return images;
}

// Hashes the files of the atlases, independent of folder names.
void hashLiverInputs(StateHash& hash, const BuildSettings& settings) {
    if (settings.trust_axes) hash.add(std::string_view("trust_axes"));
    for (const std::filesystem::path& folder : settings.atlases)
        for (const char* file : {"patient.toml", "ct.nii.gz", "labels.nii.gz"})
            hash.add(fileDigest(folder / file));
    hash.add(fileDigest(childProgram({}, "stylet-register")));
}

// Bone, and what is too dense to be blood.
Mask denseTissue(const BuildState& work) {
    const Mask bones = labelMask(work.found.at("bones"), isBone);
    return maskWhere(work.ct.grid, [&](std::size_t i) {
        return bones.voxels[i] || (work.body.voxels[i] && work.ct.voxels[i] > kDensestBlood_hu);
    });
}

void findLiverStage(BuildState& work, StageResult& r) {
    AtlasSettings atlas;
    atlas.progress = [&](std::string_view name) { work.progress(std::string(name)); };
    const Mask lungs = labelMask(work.found.at("lungs"), isLung),
               bones = labelMask(work.found.at("bones"), isBone);
    atlas.trust_axes = work.settings->trust_axes;
    atlas.scan = work.settings->ct;
    if (!work.settings->trust_axes) {
        checkUpright(work.body, lungs, work.settings->ct);
        checkFrontAndBack(work.body, bones, work.settings->ct);
    }
    const AtlasPrior prior = alignAtlases(work.ct, work.body, lungs, atlasImages(work, atlas), atlas);
    Liver liver = findLiver(work.ct, work.body, lungs, bones, prior, {.blur_m = work.blur.within_m});
    const Mask calcified = calcifiedLiver(denseTissue(work), liver.mask);
    if (const double ml = volume_ml(calcified); ml > 0.0) {
        // Blur has made the tissue around them as bright as bone, too.
        const Mask near = dilated(calcified, blurReach(work.ct.grid, work.blur));
        const Mask halo = maskWhere(bones.grid, [&](std::size_t i) {
            return near.voxels[i] && !bones.voxels[i] && work.ct.voxels[i] > work.thresholds.t2_sensitive_hu;
        });
        liver.mask = unite(liver.mask, unite(calcified, halo));
        liver.notes.push_back(
            fmt::format("{:.1f} ml inside the liver are as dense as bone: taken for calcified liver", ml));
    }
    paintTarget(r, liver.mask, "liver");
    r.record.notes = liver.notes;
    r.record.atlases = prior.used;
}
void restoreLiver(BuildState& work, const StageResult& r) {
    checkNotOwnAtlas(work.settings->name, r.record.atlases);
    work.atlases = r.record.atlases;
}

void findVesselsStage(BuildState& work, StageResult& r) {
    // The blurred border of a calcification is as bright as a vessel.
    const Mask whole = liverMask(work);
    const Mask liver =
        subtract(whole, dilated(intersect(whole, denseTissue(work)), blurReach(work.ct.grid, work.blur)));
    const FoundVessels found = findVessels(work.ct, liver);
    const SplitVessels split = splitVessels(work.ct, liver, found.vessels);
    paintTarget(r, found.suspected, "suspected vessels");
    paintTarget(r, split.cava, "vena cava and renal veins");
    paintTarget(r, split.portal, "portal vein");
    paintTarget(r, split.hepatic, "hepatic veins");
    r.record.notes = split.notes;
}

void hashVirtualDucts(StateHash& hash, const BuildSettings& settings) {
    hash.add(std::uint64_t(settings.virtual_ducts));
}

void findDuctsStage(BuildState& work, StageResult& r) {
    const LabelVolume& vessels = work.found.at("vessels");
    const Mask liver = liverMask(work), portal = labelMask(vessels, "portal vein");
    const Mask all = labelMask(vessels, [](const Label& l) { return l.tissue == patient::Tissue::vessel; });
    const BuiltDucts ducts =
        buildDucts(work.ct, liver, portal, all, work.settings->virtual_ducts, {.source = work.settings->ct});
    paintTarget(r, ducts.mask, "bile ducts");
    r.record.notes = {ducts.note};
    r.record.virtual_ducts = ducts.origin == DuctsOrigin::grown;
    if (r.record.virtual_ducts)
        r.record.notes.push_back("these ducts are virtual: bile is painted into the CT");
}
// Paints virtual ducts into the CT from their labels, so that a person's corrections are painted too.
void restoreDucts(BuildState& work, const StageResult& r) {
    work.virtual_ducts = r.record.virtual_ducts;
    if (!work.virtual_ducts) return;
    GrownDucts ducts;
    ducts.mask = labelMask(r.labels, "bile ducts");
    ducts.coverage = boxMean(toFloat(ducts.mask), 1);
    work.painted_ct = work.ct;
    paintBile(work.painted_ct, ducts, liverMask(work), DuctSettings{}.bile_hu);
}

// Rebuilds the lungs from the label maps of earlier stages, which a person may have corrected.
Lungs lungsFromLabels(const BuildState& work) {
    const LabelVolume& found = work.found.at("lungs");
    Lungs lungs;
    lungs.right = labelMask(found, "right lung");
    lungs.left = labelMask(found, "left lung");
    lungs.airways = withLabel(found, kAirways);
    lungs.gas = labelMask(found, "bowel gas");
    lungs.base_right = lungBase(lungs.right, work.body);
    lungs.base_left = lungBase(lungs.left, work.body);
    return lungs;
}
// Omits the calcified parts of the liver, which the liver stage found not to be bone.
Bones bonesFromLabels(const BuildState& work) {
    LabelVolume found = work.found.at("bones");
    const Mask liver = liverMask(work);
    for (std::size_t i = 0; i < found.voxels.size(); ++i)
        if (liver.voxels[i]) found.voxels[i] = 0;
    Bones bones;
    bones.all = labelMask(found, isBone);
    bones.spine = labelMask(found, "spine");
    bones.ribs_right = labelMask(found, "right ribs");
    bones.ribs_left = labelMask(found, "left ribs");
    bones.sternum = labelMask(found, "sternum");
    bones.canal = labelMask(found, "spinal canal");
    bones.cartilage = labelMask(found, "cartilage and discs");
    bones.canal_m = sliceCentroids(bones.canal);
    return bones;
}

// Lungs and liver: the only organs inside the fascia that are known before the organ stage.
Mask lungsAndLiver(const BuildState& work) {
    return unite(labelMask(work.found.at("lungs"), isLung), liverMask(work));
}

void findOrgansStage(BuildState& work, StageResult& r) {
    const Lungs lungs = lungsFromLabels(work);
    Bones bones = bonesFromLabels(work);
    // The organ rules do not read these, and need the memory.
    for (Mask* unused : {&bones.spine, &bones.ribs_right, &bones.ribs_left, &bones.sternum})
        *unused = {};
    const Mask liver = liverMask(work), portal = labelMask(work.found.at("vessels"), "portal vein");
    const Mask inside = [&] {
        const Mask known = lungsAndLiver(work);
        const FasciaInput first{work.ct, work.body, bones.all, known};
        return insideFascia(fitFascia(first), first);
    }();
    for (const FoundOrgan& organ : findOrgans({work.ct, work.body, lungs, bones, liver, portal, inside})) {
        paintTarget(r, organ.mask, organ.name.c_str());
        r.record.notes.push_back(fmt::format("{}: confidence {:.2f}{}{}", organ.name, organ.confidence,
                                             organ.note.empty() ? "" : "; ", organ.note));
    }
}

void findFasciaStage(BuildState& work, StageResult& r) {
    const Bones bones = bonesFromLabels(work);
    const Mask organs = unite(lungsAndLiver(work), labelMask(work.found.at("organs"), isInsideFascia));
    const Mask certain = withoutRim(organs);
    const FasciaInput input{work.ct, work.body, bones.all, certain};
    if (r.text.empty()) r.text = writeFascia(fitFascia(input));
    const Mask inside = insideFascia(parseFascia(kControlPoints, r.text), input);
    // Inside the fascia there is no costal cartilage, but muscle, stomach and spleen, which have similar HU.
    const Mask ends = unite(bones.ribs_right, unite(bones.ribs_left, bones.sternum));
    const Mask cartilage = subtract(
        costalCartilage(work.ct, work.body, work.blur, inside, {bones.all, ends, bones.spine, bones.canal}),
        organs);
    paintTarget(r, cartilage, "cartilage and discs");
    const Mask fascia = fasciaVoxels(inside, input);
    const Mask liver = liverMask(work);
    const Mask liver_and_spleen = unite(liver, labelMask(work.found.at("organs"), "spleen"));
    const Mask muscle = muscleAtFascia(organs, liver_and_spleen, inside, fascia);
    paintTarget(r, muscle, "muscle");
    paintTarget(r, strayLiver(subtract(liver, unite(muscle, fascia)), inside), "muscle");
    paintTarget(r, fascia, "fascia");
    const LabelVolume &in_bones = work.found.at("bones"), &in_organs = work.found.at("organs");
    const Mask taken = maskWhere(work.ct.grid, [&](std::size_t i) {
        return organs.voxels[i] || in_bones.voxels[i] || in_organs.voxels[i];
    });
    paintTarget(
        r, cartilageRim(work.ct, work.body, work.blur, cartilage, taken, work.thresholds.t2_sensitive_hu),
        "muscle", false);
}

void findSkin(BuildState& work, StageResult& r) {
    paintTarget(r, skinShell(work.body, work.scan, kSkin_m), "skin");
}

std::vector<Stage> makeStages() {
    return {
        {.name = "body", .find = findBody, .restore = restoreBody},
        {.name = "classes", .text_name = "classes.json", .find = findClasses, .restore = restoreClasses},
        {.name = "lungs", .provides = {"right lung", "left lung"}, .find = findLungsStage},
        {.name = "bones",
         .provides = {"right ribs", "left ribs", "spine", "spinal canal", "sternum", "bone",
                      "cartilage and discs", "muscle"},
         .find = findBonesStage},
        {.name = "liver",
         .provides = {"liver"},
         .find = findLiverStage,
         .hash_inputs = hashLiverInputs,
         .restore = restoreLiver},
        {.name = "vessels",
         .provides = {"suspected vessels", "portal vein", "hepatic veins"},
         .find = findVesselsStage},
        {.name = "ducts",
         .provides = {"bile ducts"},
         .find = findDuctsStage,
         .hash_inputs = hashVirtualDucts,
         .restore = restoreDucts},
        {.name = "organs",
         .provides = {"right kidney", "left kidney", "spleen", "heart", "aorta and arteries",
                      "vena cava and renal veins", "portal vein", "gallbladder", "stomach and oesophagus",
                      "colon", "small bowel", "bowel gas"},
         .over_all = false,
         .find = findOrgansStage},
        {.name = "fascia",
         .text_name = kControlPoints,
         .provides = {"fascia", "cartilage and discs", "muscle"},
         .find = findFasciaStage},
        {.name = "skin", .provides = {"skin"}, .over_all = false, .find = findSkin},
    };
}

std::vector<Label> makeStageTable() {
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
    static const std::vector<Label> table = makeStageTable();
    return table;
}

}  // namespace stylet::modeller
