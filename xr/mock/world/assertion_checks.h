// Checks the scenario's assertions: on each submitted frame, on each session state, and at the end.
#pragma once

#include <string>

#include "scenario/assertions.h"

namespace xrmock {

class Call;
struct Instance;
struct Session;
struct SubmittedFrame;

// Checks a frame. Assertions about frames skip frames with shouldRender false.
void checkFrameAssertions(Call& call, Session& session, const SubmittedFrame& frame);
void checkStateAssertions(Instance& instance, XrSessionState state);
// Call at the end. Returns the reason why the assertion failed, or "" if it holds.
std::string evaluateAssertion(const Assertion& assertion, const Instance& instance);

}  // namespace xrmock
