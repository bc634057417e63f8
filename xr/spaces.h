// The stage frame: which reference space it is, and what happens to it.
#pragma once

#include <string>
#include <vector>

#include "xr/instance.h"
#include "xr/pose.h"

namespace stylet::xr {

class Spaces {
  public:
    // The steadiest space the runtime has: stationary, else stage, local_floor, local. Throws XrError.
    void create(const Instance&, XrSession, bool stationary, std::vector<std::string>& notes);

    XrSpace stage() const { return stage_.get(); }
    XrSpace head() const { return head_.get(); }
    const char* name() const { return name_; }
    // Nothing when it is another space that changes.
    std::optional<SpaceChange> changeOf(const XrEventDataReferenceSpaceChangePending&) const;
    // Of the stationary space, else "".
    std::string generation(const Instance&, XrSession) const;

  private:
    Owned<XrSpace, xrDestroySpace> stage_, head_;
    XrReferenceSpaceType type_ = XR_REFERENCE_SPACE_TYPE_MAX_ENUM;
    const char* name_ = "";
    Pose reference_from_stage_;
};

}  // namespace stylet::xr
