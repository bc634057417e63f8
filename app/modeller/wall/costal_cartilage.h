// The cartilage between the ribs and the sternum. A needle cuts it, but hard. A CT shows it poorly.
#pragma once

#include "app/modeller/image/scan_blur.h"

namespace stylet::modeller {

struct RibCage {
    const Mask& all;
    const Mask& ends;   // to which cartilage may be attached: ribs and sternum
    const Mask& spine;  // no cartilage is searched beside it; may be empty
    const Mask& canal;  // may be empty
};

// The costal cartilage that is clearly denser than muscle: outside the fascia (`inside` is the enclosed
// volume), below the skin's fat, in front, and connected to one of the `ends`. Empty if voxels are wider than
// 1.25 mm.
Mask costalCartilage(const CtVolume&, const Mask& body, const ScanBlur&, const Mask& inside, const RibCage&);

// Muscle that the blur of calcified cartilage makes as bright as bone (`bone_hu`). Leaves out what is `taken`
// by other structures, and voxels too dense for blur: they are missed bone.
Mask cartilageRim(const CtVolume&, const Mask& body, const ScanBlur&, const Mask& cartilage,
                  const Mask& taken, double bone_hu);

}  // namespace stylet::modeller
