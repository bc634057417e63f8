#include "haptics/devices/entry.h"
#ifdef STYLET_HIDAPI
#include "haptics/devices/hid_port.h"
#include "haptics/devices/woodenhaptics/woodenhaptics.h"
#include "patient/patient.h"
#endif

namespace stylet::haptics {

#ifdef STYLET_HIDAPI

namespace {

void findWooden(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    findHid(found, "woodenhaptics", isWoodenBoard,
            options.model.empty() ? "its dimensions are needed: pass the woodenhaptics.json of its maker's "
                                    "library with --device-model"
                                  : "");
}

WoodenModel woodenModel(const DeviceOptions& options) {
    if (options.model.empty())
        throw DataError(
            "woodenhaptics", "--device-model",
            "not given: the woodenhaptics.json of the maker's library is needed, which holds this "
            "device's dimensions");
    return loadWoodenModel(options.model);
}

DeviceProfile woodenProfile(const DeviceOptions& options) {
    if (options.model.empty())
        return {.name = "woodenhaptics",
                .force_peak_n = kUnknown,
                .stiffness_n_per_m = kUnknown,
                .source = "in its model file"};
    DeviceProfile profile = makeProfile(loadWoodenModel(options.model));
    profile.name = "woodenhaptics";
    return profile;
}

std::unique_ptr<Driver> makeWooden(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<WoodenHaptics>(clock, woodenModel(options));
}

}  // namespace

extern const DeviceEntry kWoodenHapticsEntry{
    {"woodenhaptics", "WoodenHaptics or Polhem v1, open hardware (USB HID)", nullptr},
    findWooden,
    woodenProfile,
    makeWooden};

#else

extern const DeviceEntry kWoodenHapticsEntry{
    {"woodenhaptics", "WoodenHaptics or Polhem v1, open hardware (USB HID)", "libhidapi-dev"},
    nullptr,
    nullptr,
    nullptr};

#endif

}  // namespace stylet::haptics
