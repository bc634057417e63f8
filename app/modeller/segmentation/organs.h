// Finds the organs around the liver, each by its own rule: position, density and size. No rule is certain;
// each reports its confidence. CT values are compared with the liver's and expected to be of the portal
// venous phase. Without contrast medium, kidneys, heart and vessels are missed or wrong.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/segmentation/bones.h"
#include "app/modeller/segmentation/lungs.h"

namespace stylet::modeller {

// All on one grid.
struct OrganInput {
    const CtVolume& ct;
    const Mask& body;
    const Lungs& lungs;
    const Bones& bones;
    const Mask& liver;   // all 0 if unknown: spleen and heart are then less certain
    const Mask& portal;  // the portal vein in the liver; all 0 if unknown
    const Mask& inside;  // the volume inside the fascia
};

struct FoundOrgan {
    std::string name;  // name in targetTable()
    Mask mask;         // empty if not found
    // From 0 (not found) to 1. Of organs with at least 0.9, nine in ten have a Dice coefficient above 0.85
    // (`packaging/bench --cohort` measures it).
    double confidence = 0.0;
    std::string note;  // one sentence if something is doubtful
};

// Returns right and left kidney, spleen, heart, aorta and arteries, vena cava and renal veins, portal vein
// (outside the liver), gallbladder, stomach and oesophagus, colon, small bowel, bowel gas: always all of
// them, in this order. No two overlap, and none overlaps liver, lung or bone.
std::vector<FoundOrgan> findOrgans(const OrganInput&);

}  // namespace stylet::modeller
