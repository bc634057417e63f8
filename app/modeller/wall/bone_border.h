// The border of a bone in a scan that is blurred.
#pragma once

#include "app/modeller/image/scan_blur.h"

namespace stylet::modeller {

// Halfway between muscle (55 HU) and a rib's cortex of 1 mm, which blur lowers to 350 HU.
inline constexpr std::int16_t kBone_hu = 200;

// True if the scan is so soft, or its slices so thick, that the borders of bones are uncertain by a voxel.
bool hidesBoneBorders(const Grid&, const ScanBlur&);

// A scan, and the same scan with most of its blur undone. Refers to the CT and the body.
struct BoneScan {
    BoneScan(const CtVolume&, const Mask& body, const ScanBlur&);
    const CtVolume& ct;
    const Mask& body;
    ScanBlur blur;
    FloatVolume sharp;  // HU
};

// Removes the soft tissue that blur has raised above the bone threshold. A bone's surface is at half maximum:
// halfway between the muscle beside it and its cortex. Blur lowers a thin cortex but not muscle, so half of
// the blurred maximum lies outside the bone (cf. Prevrhal, Engelke and Kalender, "Accuracy limits for the
// determination of cortical width and density", Phys. Med. Biol. 44, 1999). Bone is therefore measured in the
// sharpened scan. Nothing is removed beside the spinal `canal`, which may be empty.
Mask withoutBlurredRim(const BoneScan&, const Mask& bone, const Mask& canal);

}  // namespace stylet::modeller
