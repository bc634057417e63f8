// The organs about the liver, each by a rule of its own: where it lies, how dense it is, how large. No rule
// is sure; each says how sure it is. Values are relative to the liver's, for the portal venous phase: without
// contrast medium kidneys, heart and vessels are missed or wrong.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/build/bones.h"
#include "app/modeller/build/lungs.h"

namespace stylet::modeller {

// All on one grid.
struct OrganInput {
    const patient::CtVolume& ct;
    const Mask& body;
    const Lungs& lungs;
    const Bones& bones;
    const Mask& liver;   // all 0 where it is not known: spleen and heart are then less sure
    const Mask& inside;  // of the fascia
};

struct FoundOrgan {
    std::string name;         // of targetTable()
    Mask mask;                // empty where it was not found
    double confidence = 0.0;  // 0 (not found) to 1
    std::string note;         // one sentence where something is doubtful
};

// Right and left kidney, spleen, heart, aorta and arteries, vena cava and renal veins, gallbladder, stomach
// and oesophagus, colon, bowel gas, always all of them and in this order; no two overlap, none overlaps
// liver, lung or bone.
std::vector<FoundOrgan> findOrgans(const OrganInput&);

}  // namespace stylet::modeller
