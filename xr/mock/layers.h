// What xrEndFrame accepts.
#pragma once

#include <vector>

#include "call.h"
#include "capture.h"

namespace xrmock {

// Refuses the frame if a layer is not as specified. Returns the sub-images of the first projection layer.
std::vector<SubImage> checkLayers(Call& call, Session& session, const XrFrameEndInfo& frame);

}  // namespace xrmock
