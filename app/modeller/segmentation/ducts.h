// Dilated bile ducts: dark tubes in the liver.
#pragma once

#include <string>

#include "app/modeller/import/import_ducts.h"

namespace stylet::modeller {

enum class DuctsOrigin { none, visible, grown };

struct BuiltDucts {
    DuctsOrigin origin = DuctsOrigin::none;
    Mask mask;         // on the CT's grid
    GrownDucts grown;  // if grown: input of paintBile; virtual, not the patient's own
    std::string note;  // one sentence: the result or the reason for none, and whether it is virtual
};

// Finds the dilated ducts visible in the CT. Uses a line filter for dark tubes of 1.3 to 5 mm radius with
// values about halfway from parenchyma to bile or darker. Excludes blobs (tumours, cysts, the gallbladder),
// fat, gas and anything that does not form a tree. The liver's mask may lack the ducts and the hilum. Empty
// if no ducts are dilated: normal ducts of 1 mm are not visible. Also empty if the liver is hardly brighter
// than bile. If given, `note` receives one sentence with the reason for the decision.
Mask findVisibleDucts(const CtVolume&, const Mask& liver, std::string* note = nullptr);

// Returns the visible ducts. If there are none and `grow` is set, grows ducts beside the portal vein with
// growDucts(). Throws ImportError if growDucts() does.
BuiltDucts buildDucts(const CtVolume&, const Mask& liver, const Mask& portal, const Mask& vessels, bool grow,
                      const DuctSettings& = {});

}  // namespace stylet::modeller
