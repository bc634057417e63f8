// Composes the image of a frame as an eye sees it: intersects the eye's rays with each layer and paints the
// layers.
#pragma once

#include "compositor/compositor.h"
#include "world/submitted_frame.h"

namespace xrmock {

// Composes what an eye (0 left, 1 right) sees at the frame's display time; black where no layer is. The
// image has the size of the first projection layer's sub-image, so that a layer submitted with the eye's
// own pose and field of view is reproduced pixel by pixel. Without a projection layer it has the
// recommended size. Throws Refused if Vulkan fails.
Picture composeEye(Session& session, const SubmittedFrame& frame, std::size_t eye);

}  // namespace xrmock
