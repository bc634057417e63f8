// Captures: the pictures of the two eyes, as files.
#pragma once

#include <string>

#include "call.h"
#include "submitted_frame.h"

namespace xrmock {

// The name after "capture:", or empty when the label asks for no capture or for no plain file name.
std::string captureName(const std::string& label);

// The bytes of a PNG file of what the eye (0 left, 1 right) sees. Waits for the GPU; tells messengers of
// performance how long that took. Throws std::runtime_error or Refused.
std::string eyePng(Call& call, Session& session, const SubmittedFrame& frame, std::size_t eye);

// Makes the pictures that are due with this frame, unless nobody will ever see it: FOLDER/NAME_left.png and
// FOLDER/NAME_right.png. Waits for the GPU. A picture that fails does not fail the frame: the application did
// nothing wrong.
void captureIfDue(Call& call, Session& session, const SubmittedFrame& frame);

// FOLDER/frames.json: what the instance counted.
void writeStatistics(const Instance& instance);

}  // namespace xrmock
