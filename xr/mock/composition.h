// What an eye sees of a frame: where its rays meet each layer, and the picture that comes of it.
#pragma once

#include "compositor.h"
#include "submitted_frame.h"

namespace xrmock {

// What the eye (0 left, 1 right) sees of the frame at its display time: black where nothing was painted. The
// picture has the size of the first projection layer's sub-image, so that a layer submitted as the eye sees
// it is reproduced pixel by pixel; without one, the recommended size. Throws Refused when Vulkan fails.
Picture composeEye(Session& session, const SubmittedFrame& frame, std::size_t eye);

}  // namespace xrmock
