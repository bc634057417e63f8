// Notifies the observers of the application's calls: the log, the assertions and the `wait` requests of
// control clients.
#pragma once

#include <cstdint>
#include <string>

#include "scenario/openxr_api.h"

namespace xrmock {

class Call;
struct Session;
struct SubmittedFrame;

void observeState(Session& session, XrSessionState state);
// Called inside xrEndFrame, while the frame's pointers are valid.
void observeFrame(Call& call, Session& session, const SubmittedFrame& frame);
// Records a call that was refused because the application violated the specification.
void observeRefusal(const Call& call, XrResult result, const std::string& reason);

}  // namespace xrmock
