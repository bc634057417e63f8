#include "haptics/devices/devices.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "haptics/devices/falcon/falcon_firmware.h"
#include "patient/patient.h"

namespace stylet::haptics {

// In display order. Each is defined in the folder of its driver.
extern const DeviceEntry kFalconEntry, kWoodenHapticsEntry, kSpaceMouseEntry, kInverse3Entry, kBridgeEntry;

namespace {

constexpr const DeviceEntry* kEntries[] = {
    &kFalconEntry, &kWoodenHapticsEntry, &kSpaceMouseEntry, &kInverse3Entry, &kBridgeEntry,
};

const DeviceEntry& findBuiltIn(std::string_view name) {
    std::string names;
    for (const DeviceEntry* each : kEntries) {
        const DeviceEntry& entry = *each;
        if (name != entry.kind.name) {
            names += std::string(names.empty() ? "" : ", ") + entry.kind.name;
            continue;
        }
        if (entry.kind.missing)
            throw DataError(
                entry.kind.name, "device",
                std::string("not in this build: install ") + entry.kind.missing + " and build again");
        return entry;
    }
    throw DataError(std::string(name), "device", "not among: " + names);
}

}  // namespace

std::span<const DeviceKind> deviceKinds() noexcept {
    static const auto kKinds = [] {
        std::array<DeviceKind, std::size(kEntries)> kinds{};
        std::transform(std::begin(kEntries), std::end(kEntries), kinds.begin(),
                       [](const DeviceEntry* entry) { return entry->kind; });
        return kinds;
    }();
    return kKinds;
}

std::vector<FoundDevice> findDevices(const DeviceOptions& options) {
    std::vector<FoundDevice> found;
    for (const DeviceEntry* entry : kEntries)
        if (entry->find) entry->find(options, found);
    return found;
}

DeviceProfile deviceProfile(std::string_view kind, const DeviceOptions& options) {
    return findBuiltIn(kind).profile(options);
}

std::string firmwareDigest(const DeviceOptions& options) {
    return options.firmware.empty() ? "" : falcon::loadFirmwareFile(options.firmware).sha256;
}

std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions& options, const Clock& clock) {
    return findBuiltIn(kind).make(options, clock);
}

}  // namespace stylet::haptics
