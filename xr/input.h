// The controllers: one action set, suggested to each controller profile on its own so that one refusal costs
// only that controller.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "xr/check.h"

namespace stylet::xr {

class Input {
  public:
    // Adds a sentence to `notes` for each profile the runtime refuses.
    void create(XrInstance, XrSession, std::vector<std::string>& notes);
    // Once a frame, outside begin and end; poses at the predicted display time.
    XrResult sync(XrSession, XrSpace stage, XrTime);
    XrResult pulse(XrSession, int side, float amplitude, XrDuration);
    const Hand& hand(int side) const { return hands_[std::size_t(side)]; }

  private:
    struct Actions {
        XrAction grip = XR_NULL_HANDLE, select = XR_NULL_HANDLE, menu = XR_NULL_HANDLE,
                 haptic = XR_NULL_HANDLE;
    };
    void suggest(XrInstance, std::vector<std::string>& notes);
    XrResult readHand(XrSession, XrSpace stage, XrTime, int side);

    Owned<XrActionSet, xrDestroyActionSet> set_;  // owns the actions
    Actions actions_;
    std::array<XrPath, 2> sides_{};
    std::array<Owned<XrSpace, xrDestroySpace>, 2> grips_;
    std::array<Hand, 2> hands_;
};

}  // namespace stylet::xr
