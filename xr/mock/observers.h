// What an application does, for those who look on: the log, the assertions, the waits of control clients.
#pragma once

#include <cstdint>
#include <string>

#include "openxr_api.h"

namespace xrmock {

class Call;
struct Session;
struct SubmittedFrame;

void observeState(Session& session, XrSessionState state);
// Inside xrEndFrame, while the frame's pointers hold.
void observeFrame(Call& call, Session& session, const SubmittedFrame& frame);
// A call that the runtime refused because the application did not keep to the specification.
void observeRefusal(const Call& call, XrResult result, const std::string& reason);

}  // namespace xrmock
