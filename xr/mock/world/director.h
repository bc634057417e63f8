// Applies the scenario's events when they are due.
#pragma once

#include <cstdint>

#include "world/objects.h"

namespace xrmock {

// Applies the events that are due at this time or at the latest frame. Called by xrPollEvent, xrWaitFrame
// and xrSyncActions, so that runs on the virtual clock are reproducible. The instance or its session may be
// lost afterwards.
void applyDueEvents(Instance& instance, std::int64_t now_ns);

// Applies the refusals of time 0 at instance creation, so that they also affect calls before the first
// frame.
void applyInitialRefusals(Instance& instance, std::int64_t now_ns);

// Returns the scripted treatment of the frame being waited for, and consumes it.
FrameOverride popFrameOverride(Instance& instance);

// XR_EXT_user_presence: sends the event when a session begins and at every change.
void announcePresence(Session& session);

// XR_FB_display_refresh_rate: changes the rate and sends the event.
void changeRefreshRate(Instance& instance, double hz);

}  // namespace xrmock
