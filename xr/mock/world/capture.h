// Captures: writes the images of the two eyes to files.
#pragma once

#include <string>

#include "world/call.h"
#include "world/submitted_frame.h"

namespace xrmock {

// Composes the image of an eye (0 left, 1 right) and encodes it as PNG. Waits for the GPU and reports the
// duration to the debug messengers as a performance message. Throws std::runtime_error or Refused.
std::string eyePng(Call& call, Session& session, const SubmittedFrame& frame, std::size_t eye);

// Writes the pending capture, if any, to FOLDER/NAME_left.png and FOLDER/NAME_right.png. Skips frames
// without layers and dropped frames. Waits for the GPU. If the capture fails, xrEndFrame still succeeds,
// because the application is not at fault. The instance's first failure is printed on stderr and logged.
void captureIfDue(Call& call, Session& session, const SubmittedFrame& frame);

// Writes the instance's statistics to FOLDER/frames.json. Reports a failure like a capture's.
void writeStatistics(Instance& instance);

}  // namespace xrmock
