// The stage frame: its reference space, and changes of its origin.
#pragma once

#include <string>
#include <vector>

#include "xr/instance.h"
#include "xr/pose.h"

namespace stylet::xr {

class Spaces {
  public:
    // Creates the most stable space that the runtime offers: stationary if requested, else stage,
    // local_floor or local. Throws XrError.
    void create(const Instance&, XrSession, bool stationary, std::vector<std::string>& notes);

    XrSpace stage() const { return stage_.get(); }
    XrSpace head() const { return head_.get(); }
    const char* name() const { return name_; }
    // Returns nullopt if the event is about another space.
    std::optional<SpaceChange> toSpaceChange(const XrEventDataReferenceSpaceChangePending&) const;
    // Generation id of the stationary space, or "" for other spaces.
    std::string generation(const Instance&, XrSession) const;

  private:
    Owned<XrSpace, xrDestroySpace> stage_, head_;
    XrReferenceSpaceType type_ = XR_REFERENCE_SPACE_TYPE_MAX_ENUM;
    const char* name_ = "";
    Pose reference_from_stage_;
};

}  // namespace stylet::xr
