#include "xr/pose.h"

namespace stylet::xr {

Pose toPose(const XrPosef& p) {
    return {Quat(p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z),
            Vec3(p.position.x, p.position.y, p.position.z)};
}

XrPosef toXrPose(const Pose& p) {
    const Quat q = glm::normalize(p.rotation);
    return {{float(q.x), float(q.y), float(q.z), float(q.w)},
            {float(p.position_m.x), float(p.position_m.y), float(p.position_m.z)}};
}

}  // namespace stylet::xr
