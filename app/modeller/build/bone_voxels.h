// Which voxels are bone: cortex by its brightness, marrow by the cortex around it.
#pragma once

#include "app/modeller/build/spinal_canal.h"

namespace stylet::modeller {

// Half way from muscle (55) to a cortex that is blurred over a rib's millimetre (350).
inline constexpr std::int16_t kBone_hu = 200;

// So little below the front surface (counted along y) that a sternum lies there, and no kidney.
bool isInFrontWall(const Mask& body, const patient::Index3& at);

// Pieces above kBone_hu that are bone: enough of them sure cortex, or in the front wall.
Mask bonePieces(const patient::CtVolume&, const Mask& body);
// Bright voxels at the cortex: what of a piece is vessel or kidney lies further from any.
Mask shellOf(const patient::CtVolume&, const Mask& pieces);
// What `count` steps from a voxel come to first.
enum class Met { bone, nothing, border };
Met meets(const Mask& wall, patient::Index3 at, const patient::Index3& step, int count);
// Spongy bone is what its cortex hems in, whether as bright as bone or not; in rounds, for what the first
// fills hems in the next. In a vertebra's place less of a cortex is asked for: a vessel beside it is hemmed
// in on one side only. Narrow marrow (ribs, arches) may be as dark as fat.
Mask withMarrow(const patient::CtVolume&, const Mask& body, const Mask& pieces, const Mask& shell,
                const SpinalCanal&);

}  // namespace stylet::modeller
