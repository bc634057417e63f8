#include "haptics/devices/entry.h"
#ifdef STYLET_HIDAPI
#include "haptics/devices/spacemouse/spacemouse.h"
#endif

namespace stylet::haptics {

#ifdef STYLET_HIDAPI

namespace {

void findCaps(const DeviceOptions&, std::vector<FoundDevice>& found) {
    findHid(found, "spacemouse", isSpaceMouseEntry, "");
}
DeviceProfile capProfile(const DeviceOptions&) {
    return spaceMouseProfile();
}
std::unique_ptr<Driver> makeCap(const DeviceOptions&, const Clock& clock) {
    return std::make_unique<SpaceMouse>(clock);
}

}  // namespace

extern const DeviceEntry kSpaceMouseEntry{
    {"spacemouse", "SpaceMouse: moves the needle, gives no force (USB HID)", nullptr},
    findCaps,
    capProfile,
    makeCap};

#else

extern const DeviceEntry kSpaceMouseEntry{
    {"spacemouse", "SpaceMouse: moves the needle, gives no force (USB HID)", "libhidapi-dev"},
    nullptr,
    nullptr,
    nullptr};

#endif

}  // namespace stylet::haptics
