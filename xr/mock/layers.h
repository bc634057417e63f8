// What xrEndFrame accepts.
#pragma once

#include "call.h"
#include "submitted_frame.h"

namespace xrmock {

// Refuses the frame if it or one of its layers is not as specified; otherwise the frame as the runtime sees
// it.
SubmittedFrame checkFrame(Call& call, Session& session, const XrFrameEndInfo& frame);

}  // namespace xrmock
