// Brings about what the scenario holds for this time and frame.
#pragma once

#include <cstdint>

#include "objects.h"

namespace xrmock {

// Applies the events that are due at the time or at the newest frame. Called by xrPollEvent, xrWaitFrame and
// xrSyncActions, so that runs on the virtual clock repeat exactly. The instance or its session may be lost
// afterwards.
void direct(Instance& instance, std::int64_t now_ns);

// Applies the refusals of time 0, which the calls before the first frame may meet, too.
void refuseFromTheStart(Instance& instance, std::int64_t now_ns);

// The fate of the frame that is waited for now.
FrameFate takeFate(Instance& instance);

// XR_EXT_user_presence: a session that begins is told, and whenever it changes.
void announcePresence(Session& session);

// XR_FB_display_refresh_rate: changes the rate and tells the application.
void changeRefreshRate(Instance& instance, double hz);

}  // namespace xrmock
