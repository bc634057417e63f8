// Dilated bile ducts: dark tubes in the liver.
#pragma once

#include <string>

#include "app/modeller/import_ducts.h"

namespace stylet::modeller {

enum class DuctsOrigin { none, seen, grown };

struct BuiltDucts {
    DuctsOrigin origin = DuctsOrigin::none;
    Mask mask;         // on the CT's grid
    GrownDucts grown;  // where they are grown: what paintBile takes; virtual, never this patient's own
    std::string note;  // one sentence on what was found, or why not, and whether it is virtual
};

// Dilated ducts as the CT shows them: line filter for dark tubes of 1.3 to 5 mm radius, halfway between
// parenchyma and bile, without blobs (tumours, cysts, the gallbladder), fat and gas, and without what is no
// tree. The liver's mask may lack the ducts and the hilum. Empty where none are dilated: normal ducts of 1 mm
// do not show. `note`, where given, is told in one sentence what decided.
Mask seenDucts(const patient::CtVolume&, const Mask& liver, std::string* note = nullptr);

// Those; where none are seen and `grow` is set, growDucts beside the portal vein. Throws ImportError as that
// does.
BuiltDucts buildDucts(const patient::CtVolume&, const Mask& liver, const Mask& portal, const Mask& vessels,
                      bool grow, const DuctSettings& = {});

}  // namespace stylet::modeller
