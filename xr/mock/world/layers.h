// Validation of the layers passed to xrEndFrame.
#pragma once

#include "world/call.h"
#include "world/submitted_frame.h"

namespace xrmock {

// Refuses the frame if it or one of its layers violates the specification. Otherwise returns the frame in
// the runtime's own form.
SubmittedFrame checkFrame(Call& call, Session& session, const XrFrameEndInfo& frame);

}  // namespace xrmock
