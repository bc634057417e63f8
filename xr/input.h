// User input: controllers through one action set, otherwise tracked bare hands.
#pragma once

#include <array>
#include <atomic>
#include <string>
#include <vector>

#include "xr/hands.h"
#include "xr/profiles.h"

namespace stylet::xr {

class Input {
  public:
    // Adds a sentence to `notes` for each binding the runtime refuses. Throws XrError.
    void create(const Instance&, XrSession, std::vector<std::string>& notes);
    // Call once per frame, before xrBeginFrame. Poses are those at the predicted display time.
    XrResult sync(XrSession, XrSpace stage, XrTime);
    // The active interaction profiles, left and right; "" for none.
    XrResult readProfiles(const Instance&, XrSession, std::array<std::string, 2>& profiles) const;
    XrResult pulse(XrSession, int side, float amplitude, XrDuration);
    const Hand& hand(int side) const { return hands_[std::size_t(side)]; }
    // Any thread, once created.
    std::optional<Pose> gripAt(XrSpace stage, XrTime, int side) const;

  private:
    void createActions(const Instance&);
    XrResult readHand(XrSession, XrSpace stage, XrTime, int side);

    Owned<XrActionSet, xrDestroyActionSet> set_;  // owns the actions
    Actions actions_;
    std::array<XrPath, 2> sides_{};
    std::array<Owned<XrSpace, xrDestroySpace>, 2> grips_, aims_;
    Hands bare_hands_;
    std::array<Hand, 2> hands_;
    std::array<std::atomic<bool>, 2> is_bare_{};  // no controller is active, as of the last sync
};

}  // namespace stylet::xr
