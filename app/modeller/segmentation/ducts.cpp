#include "app/modeller/segmentation/ducts.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/modeller/segmentation/tube_evidence.h"

namespace stylet::modeller {

namespace {

const std::vector<double> kDuctRadii_m{0.0013, 0.002, 0.003, 0.0045};
constexpr double kBile_hu = 10.0;  // 0 to 20: Prokop and Galanski 2003
// Upper limit of fat and gas, after the blur kFatBlur_m. Bile is above this value, even with noise. Blurred
// rims of fat and gas look like bile.
constexpr double kBlurredFat_hu = -45.0, kFatBlur_m = 0.0007;
constexpr double kClosing_m = 0.006;  // closes the liver's mask, which may lack the ducts and the hilum
// A duct voxel is nearer to bile than to parenchyma. The limit is below one half, because blur reduces the
// contrast of a tube of 1.6 mm.
constexpr double kInsideDuct = 0.45, kCertainDuct = 0.7;  // fraction of the way from parenchyma to bile
constexpr double kMinNoiseWidths = 4.0;
constexpr float kMinLine = 1.5f, kCertainLine = 6.0f;  // in units of random variation
// Blobs are at least slightly dark, and wide enough for a ball that fits into no intrahepatic duct.
constexpr double kBlob = 0.27, kBlobBlur_m = 0.002, kBlobRadius_m = 0.007, kBlobRim_m = 0.0015;
// Bile within this distance of the ducts found is added to them: central ducts beside fat or a tumour.
constexpr double kCentralReach_m = 0.008;
// Minimum size of a piece of duct. Excludes cysts that pass the filter.
constexpr double kMinDuctPiece_m3 = 80e-9, kMinDuctExtent_m = 0.012;
// Below the capsule, in fissures and at the hilum, thin fat looks like bile. Real ducts also appear deeper.
constexpr double kFromCapsule_m = 0.004, kDuctDepth_m = 0.010, kMinDeepShare = 0.3;
// Minimum size of a dilated system, which covers several segments: share of the liver's volume, and of the
// diagonal of its bounding box. Normal ducts are not visible at all. The tissue around the hilum and in the
// fissure for the ligament looks like a duct, and extends over up to .29 of the diagonal in a real patient.
// Dilated ducts of reference patients have .48 (slices of 5 mm) to .85.
constexpr double kMinVolumeShare = 0.002, kMinExtentShare = 0.38;

// Distance in metres to the liver's surface, or to fat or gas in a fissure, on the grid of the evidence. 0 in
// fat and gas and outside the liver. `blobs` receives the wide dark regions.
FloatVolume depthInTissue(const CtVolume& ct, const TubeEvidence& e, Mask& blobs, double bile_contrast) {
    FloatVolume image(e.liver.grid);
    forEachVoxel(image.grid,
                 [&](const Index3& i) { image[i] = std::clamp(float(ct[e.box.low + i]), -250.0f, 250.0f); });
    const FloatVolume sharp = gaussian(image, kFatBlur_m), soft = gaussian(image, kBlobBlur_m);
    Mask outside(e.liver.grid), dark(e.liver.grid);
    for (std::size_t i = 0; i < dark.voxels.size(); ++i) {
        outside.voxels[i] = !e.liver.voxels[i] || double(sharp.voxels[i]) < kBlurredFat_hu;
        dark.voxels[i] = double(soft.voxels[i]) < e.parenchyma.mean_hu - kBlob * bile_contrast;
    }
    blobs = dilated(eroded(dark, kBlobRadius_m), kBlobRadius_m + kBlobRim_m);
    return distanceTo(outside);
}

double pieceExtent_m(const Piece& piece, const Grid& g) {
    Index3 low = g.dims, high{0};
    for (const std::size_t o : piece) {
        const Index3 at = g.voxelAt(o);
        low = glm::min(low, at), high = glm::max(high, at);
    }
    return glm::length(g.spacing_m * Vec3(high - low));
}

}  // namespace

Mask findVisibleDucts(const CtVolume& ct, const Mask& liver, std::string* note) {
    const auto setNote = [&](std::string text) {
        if (note) *note = std::move(text);
    };
    const Mask whole = closed(liver, kClosing_m);
    if (countVoxels(whole) == 0) {
        setNote("No dilated bile ducts: there is no liver to look in.");
        return Mask(ct.grid);
    }
    const TubeEvidence e = tubeEvidence(ct, whole, TubeKind::dark, kDuctRadii_m);
    const double bile_contrast = e.parenchyma.mean_hu - kBile_hu;
    const double inside = std::max(kInsideDuct * bile_contrast, kMinNoiseWidths * e.parenchyma.noise_hu);
    if (inside >= bile_contrast) {
        setNote(
            fmt::format("No dilated bile ducts can be seen: the liver, of {:.0f} HU, varies by {:.0f} HU, "
                        "and bile has {:.0f} HU.",
                        e.parenchyma.mean_hu, e.parenchyma.noise_hu, kBile_hu));
        return Mask(ct.grid);
    }
    Mask blobs;
    const FloatVolume depth_m = depthInTissue(ct, e, blobs, bile_contrast);
    Mask bile(e.liver.grid), tubes(e.liver.grid), certain(e.liver.grid);
    for (std::size_t i = 0; i < bile.voxels.size(); ++i) {
        const double contrast = double(e.contrast_hu.voxels[i]);
        const float line = e.line.voxels[i];
        bile.voxels[i] =
            e.liver.voxels[i] && contrast > inside && contrast < e.parenchyma.mean_hu - kBlurredFat_hu;
        if (!bile.voxels[i] || line < kMinLine || blobs.voxels[i] ||
            double(depth_m.voxels[i]) < kFromCapsule_m)
            continue;
        tubes.voxels[i] = 1;
        certain.voxels[i] = contrast > kCertainDuct * bile_contrast && line > kCertainLine;
    }
    const double voxel_m3 = 1e-6 * voxelVolume_ml(ct.grid);
    double tree_m3 = 0.0, tree_extent_m = 0.0;  // of the largest piece
    Mask ducts = filterComponents(tubes, [&](const Piece& piece) {
        const double volume_m3 = double(piece.size()) * voxel_m3;
        const double extent_m = pieceExtent_m(piece, e.liver.grid);
        if (volume_m3 < kMinDuctPiece_m3 || extent_m < kMinDuctExtent_m) return false;
        if (std::none_of(piece.begin(), piece.end(), [&](std::size_t o) { return certain.voxels[o] != 0; }))
            return false;
        const auto deep = std::count_if(piece.begin(), piece.end(), [&](std::size_t o) {
            return double(depth_m.voxels[o]) > kDuctDepth_m;
        });
        if (double(deep) < kMinDeepShare * double(piece.size())) return false;
        if (volume_m3 > tree_m3) tree_m3 = volume_m3, tree_extent_m = extent_m;
        return true;
    });
    const VoxelBox box = boundingBox(e.liver);
    const double least_m3 = kMinVolumeShare * double(countVoxels(e.liver)) * voxel_m3,
                 least_m = kMinExtentShare * glm::length(e.liver.grid.spacing_m * Vec3(box.high - box.low));
    if (tree_m3 < least_m3 || tree_extent_m < least_m) {
        setNote(fmt::format(
            "No dilated bile ducts: the largest dark tube in the liver holds {:.1f} ml over {:.0f} mm; "
            "a dilated system holds at least {:.1f} ml over {:.0f} mm.",
            1e6 * tree_m3, 1e3 * tree_extent_m, 1e6 * least_m3, 1e3 * least_m));
        return Mask(ct.grid);
    }
    const FloatVolume to_ducts = distanceTo(ducts);
    for (std::size_t i = 0; i < bile.voxels.size(); ++i)
        bile.voxels[i] = bile.voxels[i] && double(to_ducts.voxels[i]) < kCentralReach_m;
    ducts = floodFill(ducts, bile);
    setNote(fmt::format("Dilated bile ducts seen in the CT: {:.1f} ml, the largest tree over {:.0f} mm.",
                        1e6 * double(countVoxels(ducts)) * voxel_m3, 1e3 * tree_extent_m));
    return uncropped(ducts, e.box, ct.grid);
}

BuiltDucts buildDucts(const CtVolume& ct, const Mask& liver, const Mask& portal, const Mask& vessels,
                      bool grow, const DuctSettings& settings) {
    BuiltDucts out;
    out.mask = findVisibleDucts(ct, liver, &out.note);
    if (countVoxels(out.mask) > 0) {
        out.origin = DuctsOrigin::visible;
        return out;
    }
    if (!grow) return out;
    const Mask parenchyma = subtract(subtract(liver, vessels), portal);
    out.grown = growDucts(parenchyma, portal, vessels, settings);
    out.mask = out.grown.mask;
    out.origin = DuctsOrigin::grown;
    out.note += fmt::format(
        " Virtual ones were grown beside the portal vein: {:.1f} ml, {:.0f} branches; they are not"
        " this patient's own.",
        1e6 * out.grown.volume_m3, double(out.grown.branches));
    return out;
}

}  // namespace stylet::modeller
