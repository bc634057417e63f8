// Bounds the energy that the model's springs return by the energy that the hand has stored in them.
//
// When the needle cuts a border or passes into a softer tissue, another spring takes over, and it may hold
// more energy than the last one did: at the skin 0.306 mJ, while the hand spent 0.255 mJ on tenting (model,
// section 4; a1 = k/2, R = T_N). The hand would gain the difference by drawing back at once. Therefore it
// feels the spring as if its extension were shorter by a constant length. The shorter spring holds what the
// hand has put in: sqrt(E) = sqrt(S) - c, which scales the force by 1 - c / sqrt(S). A length that is missing
// from a spring matters less, the more the spring is stretched, and c becomes 0 when the spring relaxes. When
// the needle moves on, the hand works against friction, and c falls: at the skin to 0 within 0.1 mm.
#pragma once

#include <cmath>

#include "base/hash.h"
#include "base/realtime.h"
#include "haptics/tools/tool.h"

namespace stylet::haptics {

struct StoredEnergy {
    double springs_j = 0.0;  // S, energy of the model's springs
    double by_hand_j = 0.0;  // E, the part of S that the hand has put in, in [0, S]; S if that is negative
    Vec3 force_n{0.0};       // force of the model in the last tick

    // The share of the force that the hand feels.
    double share() const noexcept { return springs_j > 0.0 ? std::sqrt(by_hand_j / springs_j) : 1.0; }
};

// Haptics thread. Accounts for one tick in which the tool moved by `moved_m`, in the frame of the force.
// Returns the force and energy that the hand may feel: the force times the share, and E. A force that is not
// finite is returned unchanged and not accounted for.
ToolForce boundByStoredEnergy(StoredEnergy&, const ToolForce&,
                              const Vec3& moved_m) noexcept STYLET_NONBLOCKING;
void hashStoredEnergy(StateHash&, const StoredEnergy&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
