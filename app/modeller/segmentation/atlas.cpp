#include "app/modeller/segmentation/atlas.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <future>
#include <optional>

#include "app/modeller/image/handover_files.h"
#include "app/modeller/image/import_error.h"
#include "app/modeller/image/vector_field.h"
#include "app/modeller/segmentation/coarse_grid.h"
#include "base/text.h"
#include "patient/package/origin.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

using patient::BloodKind;
using patient::Label;
using patient::Package;
using patient::Tissue;

namespace {

// Values of the feature image that is registered. Air around the body and lung are far below soft tissue, and
// fat is below it. Soft tissue keeps its HU. Lower and higher values are clamped to those of fat and bone.
// Gas and stool in the bowel get a neutral value, because they do not show where organs lie.
constexpr float kFeatureOutside_hu = -300.0f, kFeatureLung_hu = -220.0f, kFeatureFat_hu = -110.0f,
                kFeatureBone_hu = 220.0f;
constexpr int kAtlasAir_hu = -400;   // darker is gas, or lung if no lung is labelled
constexpr int kBodyFloor_hu = -300;  // in an atlas, darker voxels are air outside the body
// A vote is weighted by the similarity of the features within this many voxels of the registration grid.
constexpr int kSimilarityReach = 3;
// A target counts as mirrored if exchanging left and right reduces its difference from the atlases below this
// share. Measured: 1.03 to 1.11 in a real patient, also changed in 14 ways, and 3.3 or more in reference
// patients; mirrored, the reciprocals.
constexpr double kMirroredShare = 0.98;
constexpr double kMinMeasured_ml = 30.0;  // of a liver; less says nothing about its CT value
// A voxel of a vessel or duct belongs to the liver if liver outweighs other tissue within this distance.
constexpr double kVesselReach_m = 0.006;

// Labels that belong to the liver only where they are inside it.
bool isTreeLabel(const Label& l) {
    return l.tissue == Tissue::duct || l.blood == BloodKind::portal || l.blood == BloodKind::hepatic;
}

Organ organFromTissue(const Label& l) {
    switch (l.tissue) {
        case Tissue::liver:
            return Organ::liver;
        case Tissue::skin:
        case Tissue::fascia:
        case Tissue::bone:
        case Tissue::cartilage:
            return Organ::wall;
        case Tissue::vessel:
            return l.blood == BloodKind::hepatic || l.blood == BloodKind::other ? Organ::elsewhere
                                                                                : Organ::blood;
        case Tissue::air:
        case Tissue::soft:
        case Tissue::duct:
            break;
    }
    return Organ::elsewhere;
}

Organ organFromLabel(const Label& l) {
    using enum patient::Structure;
    switch (l.structure) {
        case fat:
        case muscle:
        case cartilage:
        case spine:
        case spinal_canal:
            return Organ::wall;
        case lung:
            return Organ::lungs;
        case heart:
            return Organ::heart;
        case gallbladder:
            return Organ::gallbladder;
        case spleen:
            return Organ::spleen;
        case kidney:
            return Organ::kidneys;
        case pancreas:
            return Organ::pancreas;
        case stomach:
            return Organ::stomach;
        case colon:
        case small_bowel:
        case gas:
            return Organ::bowel;
        case visceral_fat:
        case diaphragm:
            return Organ::elsewhere;
        case tumour:  // of the liver
            return Organ::liver;
        case other:
            break;
    }
    return organFromTissue(l);
}

// The body of an atlas: the largest component that is not air, with its holes filled.
Mask findBody(const CtVolume& ct) {
    Mask body = maskWhere(ct.grid, [&](std::size_t i) { return ct.voxels[i] > kBodyFloor_hu; });
    keepLargestComponent(body);
    fillHolesPerSlice(body);
    return body;
}

float featureValue(int hu, bool body, bool lung) {
    if (!body) return kFeatureOutside_hu;
    if (lung) return kFeatureLung_hu;
    return hu < kAtlasAir_hu ? 0.0f : std::clamp(float(hu), kFeatureFat_hu, kFeatureBone_hu);
}

FloatVolume featureImage(const CtVolume& ct, const Mask& body, const auto& isLung, double spacing_m) {
    return coarseMean(coarseGrid(ct.grid, spacing_m), ct.grid, [&](std::size_t i) {
        return featureValue(ct.voxels[i], body.voxels[i] != 0, isLung(i));
    });
}

Volume<std::int16_t> rounded(const FloatVolume& image) {
    Volume<std::int16_t> out(image.grid);
    for (std::size_t i = 0; i < out.voxels.size(); ++i)
        out.voxels[i] = std::int16_t(std::lround(image.voxels[i]));
    return out;
}

FloatVolume leftRightExchanged(const FloatVolume& image) {
    FloatVolume out(image.grid);
    forEachVoxel(image.grid,
                 [&](const Index3& i) { out[i] = image[{image.grid.dims.x - 1 - i.x, i.y, i.z}]; });
    return out;
}

bool hasLiverAt(const AtlasImage& atlas, const Vec3& at) {
    return atlas.organ.nearestOr(at, std::uint8_t(Organ::elsewhere)) == std::uint8_t(Organ::liver);
}

// The median of the values that can be liver. No value if they are few.
std::optional<float> liverLevel(const FloatVolume& feature, const Mask& liver) {
    std::vector<float> hu;
    for (std::size_t i = 0; i < liver.voxels.size(); ++i)
        if (const float v = feature.voxels[i]; liver.voxels[i] && v > kMinLiver_hu && v < kMaxLiver_hu)
            hu.push_back(v);
    if (double(hu.size()) * voxelVolume_ml(liver.grid) < kMinMeasured_ml) return std::nullopt;
    return upperMedian(std::move(hu));
}

// Registers the atlases to a target.
class Registration {
  public:
    // Finds the affine transforms of all atlases, also to the mirrored target unless its axes are trusted.
    // Throws ImportError.
    Registration(const FloatVolume& target, const std::vector<AtlasImage>& atlases,
                 const AtlasSettings& settings)
        : target_(target), atlases_(atlases), settings_(settings) {
        writeImageFile(fixed(false), rounded(target));
        if (!settings.trust_axes) writeImageFile(fixed(true), rounded(leftRightExchanged(target)));
        for (std::size_t n = 0; n < atlases.size(); ++n)
            writeImageFile(moving(n), rounded(atlases[n].feature));
        const std::size_t count = (settings.trust_axes ? 1 : 2) * atlases.size();
        std::atomic<std::size_t> next{0};
        const auto work = [&] {
            for (std::size_t task = next++; task < count; task = next++) {
                const std::size_t n = task % atlases.size();
                const bool mirrored = task >= atlases.size();
                run(n, {"affine", fixed(mirrored), moving(n), affine(n, mirrored),
                        shortestText(settings_.affine_share)});
            }
        };
        auto other = std::async(std::launch::async, work);  // two processes at the same time
        work();
        other.get();
        target_liver_hu_ = targetLiverLevel();
    }

    // Throws ImportError if the atlases are more like the mirrored target.
    void checkNotMirrored() const {
        const FloatVolume mirrored = leftRightExchanged(target_);
        double difference = 0.0, of_mirrored = 0.0;
        for (std::size_t n = 0; n < atlases_.size(); ++n) {
            difference += affineDifference(target_, atlases_[n], readAffineFile(affine(n, false)));
            of_mirrored += affineDifference(mirrored, atlases_[n], readAffineFile(affine(n, true)));
        }
        if (of_mirrored < kMirroredShare * difference)
            throw ImportError(
                settings_.scan.string() +
                ": axes: left and right of the scan are exchanged: its mirror image is more like the "
                "reference patients. Correct the orientation in its file, or pass --trust-axes. Situs "
                "inversus is not supported");
    }

    // Returns the features of atlas `n` with its liver as bright as the target's. Tube voltage, contrast
    // medium and fat change the liver's value so much that another organ of the target may be more like the
    // atlas's liver.
    FloatVolume matchedFeature(std::size_t n) const {
        FloatVolume out = atlases_[n].feature;
        Mask liver(out.grid);
        parallelVoxels(out.grid,
                       [&](const Index3& i) { liver[i] = hasLiverAt(atlases_[n], out.grid.centre(i)); });
        const std::optional<float> level_hu = liverLevel(out, liver);
        if (!level_hu || !target_liver_hu_) return out;
        for (std::size_t i = 0; i < out.voxels.size(); ++i)
            if (liver.voxels[i])
                out.voxels[i] = std::min(out.voxels[i] + *target_liver_hu_ - *level_hu, kFeatureBone_hu);
        return out;
    }

    // The displacement from the target to atlas `n` with these features.
    VectorField displacement(std::size_t n, const FloatVolume& feature) const {
        writeImageFile(moving(n), rounded(feature));
        const fs::path out = folder_.path() / "field";
        run(n,
            {"demons", fixed(false), moving(n), affine(n, false), out, std::to_string(settings_.iterations)});
        VectorField field = readFieldFile(out);
        if (field.grid.dims != target_.grid.dims)
            throw ImportError("the registration of an atlas left another grid");
        field.grid = target_.grid;
        return field;
    }

  private:
    fs::path fixed(bool mirrored) const { return folder_.path() / (mirrored ? "mirrored" : "fixed"); }
    fs::path moving(std::size_t n) const { return folder_.path() / fmt::format("moving{}", n); }
    fs::path affine(std::size_t n, bool mirrored) const {
        return folder_.path() / fmt::format("affine{}{}", n, mirrored ? "-mirrored" : "");
    }
    void run(std::size_t n, const std::vector<std::string>& arguments) const {
        runChild(childProgram(settings_.program, "stylet-register"), arguments, settings_.limits,
                 atlases_[n].name, "the registration");
    }
    // Mean square of the difference after an affine registration. Around the atlas is air.
    static double affineDifference(const FloatVolume& target, const AtlasImage& atlas,
                                   const AffineMap& to_atlas) {
        double sum = 0.0;
        forEachVoxel(target.grid, [&](const Index3& i) {
            const double d = double(
                valueAt(atlas.feature, to_atlas(target.grid.centre(i)), kFeatureOutside_hu) - target[i]);
            sum += d * d;
        });
        return sum / double(target.voxels.size());
    }

    // The target's value where most atlases have liver after the affine registration.
    std::optional<float> targetLiverLevel() const {
        std::vector<AffineMap> to_atlas;
        for (std::size_t n = 0; n < atlases_.size(); ++n)
            to_atlas.push_back(readAffineFile(affine(n, false)));
        Mask liver(target_.grid);
        parallelVoxels(target_.grid, [&](const Index3& i) {
            std::size_t votes = 0;
            for (std::size_t n = 0; n < atlases_.size(); ++n)
                votes += hasLiverAt(atlases_[n], to_atlas[n](target_.grid.centre(i)));
            liver[i] = 2 * votes > atlases_.size();
        });
        return liverLevel(target_, liver);
    }

    const FloatVolume& target_;
    const std::vector<AtlasImage>& atlases_;
    const AtlasSettings& settings_;
    PrivateFolder folder_;
    std::optional<float> target_liver_hu_;
};

// Adds the atlas's votes: its organ at each voxel, weighted by the local similarity of the target and the
// atlas's features.
void addVote(const FloatVolume& target, const AtlasImage& atlas, const FloatVolume& feature,
             const VectorField& field, double similarity_hu, AtlasPrior& prior) {
    const Grid& g = target.grid;
    FloatVolume differs(g);
    LabelVolume organ(g, std::uint8_t{255});  // 255: outside the atlas
    parallelVoxels(g, [&](const Index3& i) {
        const std::size_t o = g.offset(i);
        const Vec3 p = g.centre(i) + Vec3(field.voxels[o]);
        organ.voxels[o] = atlas.organ.nearestOr(p, 255);
        const float d =
            organ.voxels[o] == 255 ? 0.0f : valueAt(feature, p, kFeatureOutside_hu) - target.voxels[o];
        differs.voxels[o] = d * d;
    });
    differs = boxMean(differs, kSimilarityReach);
    for (std::size_t o = 0; o < differs.voxels.size(); ++o) {
        if (organ.voxels[o] >= kOrgans) continue;
        const double d2 = double(differs.voxels[o]) / (similarity_hu * similarity_hu);
        prior.probability[organ.voxels[o]].voxels[o] += float(std::exp(-d2)) + 1e-6f;
        prior.known.voxels[o] += 1.0f;
    }
}

}  // namespace

Mask wholeLiver(const LabelVolume& labels, const std::vector<Label>& table) {
    std::array<std::uint8_t, 256> kind{};  // 0: other, 1: liver, 2: vessel or duct
    for (const Label& l : table)
        kind[l.id] = organFromLabel(l) == Organ::liver ? 1 : isTreeLabel(l) ? 2 : 0;
    FloatVolume liver(labels.grid), other(labels.grid);
    for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
        liver.voxels[i] = kind[labels.voxels[i]] == 1;
        other.voxels[i] = kind[labels.voxels[i]] == 0;
    }
    const int reach = std::max(1, int(std::lround(kVesselReach_m / labels.grid.spacing_m.x)));
    const FloatVolume near_liver = boxMean(liver, reach), near_other = boxMean(other, reach);
    return maskWhere(labels.grid, [&](std::size_t i) {
        return liver.voxels[i] > 0.0f ||
               (kind[labels.voxels[i]] == 2 && near_liver.voxels[i] > near_other.voxels[i]);
    });
}

void checkNotOwnAtlas(const std::string& name, const std::vector<std::string>& atlases) {
    if (std::find(atlases.begin(), atlases.end(), name) != atlases.end())
        throw ImportError("\"" + name + "\" is among the atlases of its own patient, which proves nothing (" +
                          patient::formatAtlasList(atlases) +
                          "): leave that atlas out, or give the patient another name if it is not the same");
}

AtlasImage::AtlasImage(const Package& package, const AtlasSettings& settings) : name(package.name) {
    std::array<Organ, 256> organ_of{};
    for (const Label& l : package.label_table)
        organ_of[l.id] = organFromLabel(l);
    const auto organAt = [&](std::size_t i) { return organ_of[package.labels.voxels[i]]; };
    feature = featureImage(
        package.ct, findBody(package.ct), [&](std::size_t i) { return organAt(i) == Organ::lungs; },
        settings.spacing_m);
    const Mask whole = wholeLiver(package.labels, package.label_table);
    organ = LabelVolume(package.ct.grid);
    for (std::size_t i = 0; i < organ.voxels.size(); ++i)
        organ.voxels[i] = std::uint8_t(whole.voxels[i] ? Organ::liver : organAt(i));
}

AtlasPrior alignAtlases(const CtVolume& ct, const Mask& body, const Mask& lungs,
                        const std::vector<AtlasImage>& atlases, const AtlasSettings& settings) {
    const auto isLung = [&](std::size_t i) {
        return lungs.voxels.empty() ? ct.voxels[i] < kAtlasAir_hu : lungs.voxels[i] != 0;
    };
    const FloatVolume target = featureImage(ct, body, isLung, settings.spacing_m);
    const Registration registration(target, atlases, settings);
    if (!settings.trust_axes) registration.checkNotMirrored();
    AtlasPrior prior;
    prior.grid = target.grid;
    prior.known = FloatVolume(prior.grid);
    prior.probability.assign(kOrgans, FloatVolume(prior.grid));
    for (std::size_t n = 0; n < atlases.size(); ++n) {
        settings.progress(atlases[n].name);
        const FloatVolume feature = registration.matchedFeature(n);
        addVote(target, atlases[n], feature, registration.displacement(n, feature), settings.similarity_hu,
                prior);
        prior.used.push_back(atlases[n].name);
    }
    for (std::size_t o = 0; o < prior.known.voxels.size(); ++o) {
        float sum = 0.0f;
        for (const FloatVolume& p : prior.probability)
            sum += p.voxels[o];
        for (FloatVolume& p : prior.probability)
            p.voxels[o] = sum > 0.0f ? p.voxels[o] / sum : 0.0f;
        if (!atlases.empty()) prior.known.voxels[o] /= float(atlases.size());
    }
    return prior;
}

}  // namespace stylet::modeller
