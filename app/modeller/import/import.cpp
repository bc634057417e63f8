#include "app/modeller/import/import.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "app/modeller/image/scan_blur.h"
#include "app/modeller/import/import_body.h"
#include "app/modeller/import/import_ducts.h"
#include "app/modeller/import/section.h"
#include "app/modeller/import/tissue_classes.h"
#include "app/modeller/wall/bone_border.h"
#include "app/modeller/wall/bright_rim.h"
#include "app/modeller/wall/costal_cartilage.h"
#include "app/modeller/wall/fascia_spline.h"
#include "base/text.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::Label;
using patient::Package;
using patient::Tissue;
using SourceLabels = Volume<std::int16_t>;

namespace {

constexpr double kSkin_m = 0.002;
constexpr double kAboveLiver_m = 0.060, kBelowLiver_m = 0.060;

void checkSameGrid(const Grid& ct, const Grid& labels, const ImportSettings& files) {
    const auto refuse = [&](const std::string& field, const std::string& reason) {
        throw ImportError(
            fmt::format("{}: {}: {} of the CT {}", files.labels.string(), field, reason, files.ct.string()));
    };
    const auto sides = [](const Grid& g) {
        return fmt::format("{}x{}x{} voxels", g.dims.x, g.dims.y, g.dims.z);
    };
    if (ct.dims != labels.dims) refuse("dim", sides(labels) + ", not the " + sides(ct));
    for (int d = 0; d < 3; ++d) {
        const char axis = "xyz"[d];
        if (std::fabs(ct.spacing_m[d] - labels.spacing_m[d]) > 1e-3 * ct.spacing_m[d])
            refuse("pixdim", fmt::format("voxels of {:.4g} mm along {}, not the {:.4g} mm",
                                         1e3 * labels.spacing_m[d], axis, 1e3 * ct.spacing_m[d]));
        const double off_m = labels.origin_m[d] - ct.origin_m[d];
        if (std::fabs(off_m) > 0.5 * ct.spacing_m[d])
            refuse("origin", fmt::format("lies {:.3g} mm along {} from that", 1e3 * off_m, axis));
    }
}

// Look-up table from source id to label id. Refuses unmapped ids.
std::vector<std::uint8_t> mapSourceIds(const std::vector<SourceLabel>& sources, const LabelMap& map,
                                       const ImportSettings& files) {
    std::vector<std::uint8_t> target(32768, 0);
    std::string unmapped;
    for (const SourceLabel& s : sources) {
        const auto it = map.target_of.find(s.id);
        if (it != map.target_of.end())
            target[std::size_t(s.id)] = it->second;
        else if (s.id != 0)
            unmapped += (unmapped.empty() ? "" : ", ") + std::to_string(s.id);
    }
    if (!unmapped.empty())
        throw ImportError(
            fmt::format("{}: source_id: no line for {} of {}; name a target for it, or "
                        "\"unsegmented\"",
                        files.map.string(), unmapped, files.labels.string()));
    return target;
}

// Refuses air that is mapped to a tissue. Bowel and stomach may be filled with gas.
void checkNoAir(const std::vector<SourceLabel>& sources, const fs::path& map) {
    constexpr double kAirBelow_hu = -500.0;  // halfway between air and tissue
    for (const SourceLabel& s : sources) {
        using enum patient::Structure;
        const Label* l = findTarget(s.target);
        if (!l || s.mean_hu > kAirBelow_hu || l->tissue == Tissue::air) continue;
        if (l->structure != stomach && l->structure != colon && l->structure != small_bowel)
            throw ImportError(
                fmt::format("{}: tissue: source id {} is mapped to {}, but its mean of {:.0f} "
                            "HU is that of air",
                            map.string(), s.id, s.target, s.mean_hu));
    }
}

// The section of the scan around the liver.
Grid sectionAroundLiver(const Grid& source, const SourceLabels& labels,
                        const std::vector<std::uint8_t>& target, const ImportSettings& settings) {
    const std::uint8_t liver = targetId("liver");
    const VoxelBox box = boundingBox(
        maskWhere(source, [&](std::size_t i) { return target[std::size_t(labels.voxels[i])] == liver; }));
    if (box.empty())
        throw ImportError(
            fmt::format("{}: tissue: no source id that occurs in {} is mapped to liver; without "
                        "a liver there is nothing to puncture",
                        settings.map.string(), settings.labels.string()));
    return sectionGrid(source, source.origin_m.z + box.low.z * source.spacing_m.z - kBelowLiver_m,
                       source.origin_m.z + box.high.z * source.spacing_m.z + kAboveLiver_m,
                       settings.spacing_m, settings.ct);
}

LabelVolume resampleLabels(const SourceLabels& in, const Grid& grid,
                           const std::vector<std::uint8_t>& target) {
    LabelVolume out(grid);
    parallelVoxels(grid,
                   [&](const Index3& i) { out[i] = target[std::size_t(in.nearestOr(grid.centre(i), 0))]; });
    return out;
}

// Returns the volume inside the fascia.
Mask addFascia(const BoneScan& scan, LabelVolume& labels, std::vector<std::string>& notes) {
    const Mask skeleton = labelMask(labels, [](const Label& l) { return isSkeleton(l.tissue); });
    // Published bones include their blurred rim. Inside it, the fascia would be fitted 1 mm too deep.
    const Mask bone = labelMask(labels, isBone);
    Mask rim = subtract(bone, withoutBlurredRim(scan, bone, labelMask(labels, "spinal canal")));
    // Sternum and spine keep theirs. Without it, the fascia of a real patient has a rough groove at the
    // midline, and a deep breath (25 mm) overlaps it by 0.79 instead of 0.31 mm. The forces along the paths
    // are the same.
    constexpr double kMidline_m = 0.045;
    const VoxelBox box = boundingBox(scan.body);
    const double middle_m = 0.5 * (rim.grid.centre(box.low).x + rim.grid.centre(box.high).x);
    forEachVoxel(rim.grid, [&](const Index3& i) {
        if (std::fabs(rim.grid.centre(i).x - middle_m) < kMidline_m) rim[i] = 0;
    });
    const Mask bones = subtract(skeleton, rim);
    // Unlike a program, a person knows the borders of stomach and bowel.
    const Mask organs = labelMask(labels, [](const Label& l) {
        using enum patient::Structure;
        return isInsideFascia(l) || (l.abdominal && l.structure != diaphragm && l.structure != visceral_fat);
    });
    const Mask certain = withoutRim(organs);
    const FasciaSpline fascia = fitFascia({scan.ct, scan.body, bones, certain});
    const FasciaInput input{scan.ct, scan.body, skeleton, certain};
    const Mask inside = insideFascia(fascia, input), surface = fasciaVoxels(inside, input);
    const Mask liver_and_spleen = labelMask(labels, [](const Label& l) {
        return l.tissue == Tissue::liver || l.structure == patient::Structure::spleen;
    });
    const Mask muscle = muscleAtFascia(organs, liver_and_spleen, inside, surface);
    const std::size_t taken = countVoxels(unite(muscle, intersect(organs, surface)));
    paint(labels, muscle, targetId("muscle"), true);
    paint(labels, surface, targetId("fascia"), true);
    notes.push_back(
        fmt::format("fascia: one voxel thick; it, and muscle beside it, take {:.2f} ml of the organs' rims",
                    voxelVolume_ml(labels.grid) * double(taken)));
    const Mask stray =
        strayLiver(labelMask(labels, [](const Label& l) { return l.tissue == Tissue::liver; }), inside);
    paint(labels, stray, 0, true);
    if (const double ml = volume_ml(stray); ml > 0.0)
        notes.push_back(fmt::format("liver: dropped {:.3f} ml in small pieces outside the fascia", ml));
    return inside;
}

// Labels the costal cartilage that shows, unless the segmentation has cartilage in front of the body's
// middle, where no discs are. Returns what it labels.
Mask addCostalCartilage(const BoneScan& scan, const Mask& inside, LabelVolume& labels,
                        std::vector<std::string>& notes) {
    const Grid& g = labels.grid;
    const VoxelBox box = boundingBox(scan.body), liver = boundingBox(labelMask(labels, "liver"));
    const Mask drawn = labelMask(labels, [](const Label& l) { return l.tissue == Tissue::cartilage; });
    Mask ends = labelMask(labels, isBone), cartilage(g);
    bool has_cartilage = false;
    forEachVoxel(g, [&](const Index3& i) {
        has_cartilage = has_cartilage || (drawn[i] && 2 * i.y > box.low.y + box.high.y);
        if (i.z < liver.low.z) ends[i] = 0;  // the pelvis
    });
    if (has_cartilage) return cartilage;
    const Mask bones = unite(labelMask(labels, isBone), drawn), spine = labelMask(labels, "spine"),
               canal = labelMask(labels, "spinal canal");
    const Mask found = costalCartilage(scan.ct, scan.body, scan.blur, inside, {bones, ends, spine, canal});
    for (std::size_t i = 0; i < found.voxels.size(); ++i)
        cartilage.voxels[i] = found.voxels[i] && labels.voxels[i] == 0;
    const std::size_t painted = paint(labels, cartilage, targetId("cartilage and discs"), false);
    notes.push_back(fmt::format("costal cartilage: {:.1f} ml that shows, in voxels up to 1.25 mm",
                                voxelVolume_ml(g) * double(painted)));
    return cartilage;
}

// Labels the muscle that blur makes as bright as bone, beside bones and calcified cartilage. What is above
// half maximum is bone that the segmentation missed. It stays unlabelled, and bright enough to count as bone.
// If the scan hides the borders of bones, all of it is muscle: otherwise, of two such patients with exact
// labels, 0.3 and 0.4 % of the paths end in muscle.
void addBrightMuscle(const BoneScan& scan, const Mask& cartilage, double bone_hu, LabelVolume& labels,
                     std::vector<std::string>& notes) {
    const Mask bone = labelMask(labels, isBone);
    const Mask bright = brightRim(scan.ct, scan.body, bone, bone_hu, scan.blur);
    const Mask missed = hidesBoneBorders(bone.grid, scan.blur)
                            ? bone
                            : withoutBlurredRim(scan, unite(bone, bright), labelMask(labels, "spinal canal"));
    const Mask beside_cartilage = cartilageRim(scan.ct, scan.body, scan.blur, cartilage, missed, bone_hu);
    const std::size_t painted =
        paint(labels, unite(subtract(bright, missed), beside_cartilage), targetId("muscle"), false);
    notes.push_back(
        fmt::format("muscle: {:.1f} ml beside bones and cartilage, where blur makes it as bright as bone",
                    voxelVolume_ml(labels.grid) * double(painted)));
}

void addDucts(CtVolume& ct, LabelVolume& labels, const fs::path& source, std::vector<std::string>& notes) {
    const Mask parenchyma = labelMask(labels, "liver"), portal = labelMask(labels, "portal vein");
    const Mask vessels = labelMask(labels, [](const Label& l) { return l.tissue == Tissue::vessel; });
    const DuctSettings settings{.source = source};
    const GrownDucts ducts = growDucts(parenchyma, portal, vessels, settings);
    paintBile(ct, ducts, parenchyma, settings.bile_hu);
    paint(labels, ducts.mask, targetId("bile ducts"), true);
    notes.push_back(fmt::format("ducts (virtual): {} branches, {:.0f} mm, {:.1f} ml", ducts.branches,
                                1e3 * ducts.length_m, 1e6 * ducts.volume_m3));
}

std::string labelProvenance(const Label& l, const LabelMap& map, const std::vector<SourceLabel>& sources,
                            bool added_cartilage) {
    const bool drawn =
        std::any_of(sources.begin(), sources.end(), [&](const SourceLabel& s) { return s.target == l.name; });
    const bool costal = added_cartilage && l.name == "cartilage and discs";
    const std::string by_build = "by the rule of stylet-model build";
    if (l.name == "skin") return "threshold: 2 mm shell of the body";
    if (l.name == "fascia") return "fitted to the CT " + by_build;
    if (costal && !drawn) return "costal cartilage " + by_build;
    if (l.name == "muscle" && !drawn) return "threshold: beside bones and cartilage, where blur brightens it";
    if (l.name == "bile ducts" && !drawn) return "virtual: grown beside the portal branches";
    return "manual: " + (map.source.empty() ? std::string("the imported segmentation") : map.source) +
           (l.name == "muscle" ? "; beside bones by threshold" : "") +
           (costal ? "; costal cartilage " + by_build : "");
}

void reportProgress(const ImportSettings& s, std::string_view stage) {
    if (s.progress) s.progress(stage);
}

}  // namespace

double parseReferencePhase(const std::string& phase) {
    if (phase == "inhale") return 1.0;
    if (phase == "exhale") return 0.0;
    const double v = phase.starts_with("v=")
                         ? parseNumber<double>(std::string_view(phase).substr(2)).value_or(-1.0)
                         : -1.0;
    if (!(v >= 0.0 && v <= 1.0))
        throw ImportError("reference phase \"" + phase +
                          "\" is not inhale, exhale or v=X with X from 0 to 1");
    return v;
}

std::vector<SourceLabel> listSources(const CtVolume& ct, const SourceLabels& labels, const LabelMap& map) {
    std::vector<double> count(32768, 0.0), sum(32768, 0.0);
    for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
        const auto id = std::size_t(labels.voxels[i]);
        count[id] += 1.0;
        sum[id] += ct.voxels[i];
    }
    std::vector<SourceLabel> out;
    for (std::size_t id = 0; id < count.size(); ++id) {
        if (count[id] == 0.0) continue;
        std::string target;
        if (const auto it = map.target_of.find(int(id)); it != map.target_of.end())
            target = it->second == 0 ? "unsegmented" : targetTable()[std::size_t(it->second) - 1].name;
        else if (id == 0)
            target = "unsegmented";
        out.push_back({int(id), target, count[id] * voxelVolume_ml(labels.grid), sum[id] / count[id]});
    }
    return out;
}

ImportResult buildPatient(const CtVolume& ct, const SourceLabels& labels, const LabelMap& map,
                          const ImportSettings& settings) {
    if (!(settings.spacing_m >= 0.0005 && settings.spacing_m <= 0.004))
        throw ImportError("spacing must lie between 0.5 and 4 mm");
    const double breath = parseReferencePhase(settings.reference_phase);
    checkSameGrid(ct.grid, labels.grid, settings);
    ImportResult out;
    out.sources = listSources(ct, labels, map);
    if (settings.list) settings.list(out.sources);
    if (out.sources.size() == 1 && out.sources[0].id == 0)
        throw ImportError(settings.labels.string() + ": voxels: all are 0, so nothing is segmented");
    for (const auto& [id, target] : map.target_of)
        if (std::none_of(out.sources.begin(), out.sources.end(),
                         [&](const SourceLabel& s) { return s.id == id; }))
            out.notes.push_back("the map's source id " + std::to_string(id) + " does not occur");
    const std::vector<std::uint8_t> target = mapSourceIds(out.sources, map, settings);
    checkNoAir(out.sources, settings.map);

    reportProgress(settings, "resample");
    Package& p = out.package;
    const Grid section = sectionAroundLiver(ct.grid, labels, target, settings);
    p.ct = resampleCt(ct, section);
    p.labels = resampleLabels(labels, section, target);
    if (paint(p.labels, labelMask(p.labels, "fascia"), 0, true) > 0)
        out.notes.push_back(
            "fascia: the drawn one was replaced, because a layer of one voxel leaks after resampling");
    // Measured before the crop, which removes the air that the measurement needs.
    const ScanBlur blur = measureBlur(p.ct);
    out.notes.push_back(blurText(blur));

    reportProgress(settings, "body");
    const Mask body = cropToBody(p.ct, p.labels, settings.ct, out.notes);
    checkPackageSize(p.ct.grid);

    bool added_cartilage = false;
    {
        const BoneScan scan(p.ct, body, blur);
        reportProgress(settings, "fascia and skin");
        const Mask inside = addFascia(scan, p.labels, out.notes);
        // After the fascia, so that no dropped voxel of the liver leaves a hole in the skin.
        paint(p.labels, skinShell(body, ct.grid, kSkin_m), targetId("skin"), false);

        reportProgress(settings, "thresholds");
        p.thresholds = computeThresholds(estimateTissueClasses(p.ct, body, p.labels));
        const Mask cartilage = addCostalCartilage(scan, inside, p.labels, out.notes);
        added_cartilage = countVoxels(cartilage) > 0;
        addBrightMuscle(scan, cartilage, p.thresholds.t2_sensitive_hu, p.labels, out.notes);
    }
    if (settings.grow_ducts) {
        reportProgress(settings, "ducts");
        addDucts(p.ct, p.labels, settings.labels, out.notes);
    }
    p.reference_phase = settings.reference_phase;
    p.scan.slice_m = sliceDistance(ct.grid);
    if (!blur.within_assumed) p.scan.blur_within_m = blur.within_m;

    p.name = map.source.empty() ? "imported patient" : map.source;
    p.licence = map.licence.empty() ? "unknown: ask whoever gave you the images" : map.licence;
    p.provenance = "imported by stylet-model from a CT and its segmentation" +
                   std::string(settings.grow_ducts ? ", virtual bile ducts added" : "");
    p.tissues = settings.defaults.tissues;
    p.elasticity = settings.defaults.elasticity;
    fillLabelTable(p, [&](const Label& l) { return labelProvenance(l, map, out.sources, added_cartilage); });
    reportProgress(settings, "breath");
    p.motion = patient::motionTemplate(p.labels, p.label_table, {}, {breath, 0.0});
    return out;
}

ImportResult importPatient(const ImportSettings& settings) {
    const LabelMap map = loadLabelMap(settings.map);
    reportProgress(settings, "read the CT");
    const CtVolume ct = readImage(settings.ct, ImageKind::ct, settings.reader, settings.series);
    requireHounsfield(ct, settings.ct);
    reportProgress(settings, "read the labels");
    const SourceLabels labels = readImage(settings.labels, ImageKind::labels, settings.reader);
    return buildPatient(ct, labels, map, settings);
}

}  // namespace stylet::modeller
