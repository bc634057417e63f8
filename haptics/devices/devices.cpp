#include "haptics/devices/devices.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "haptics/devices/bridge.h"
#include "haptics/devices/permission_linux.h"
#include "haptics/devices/profiles.h"
#ifdef STYLET_HIDAPI
#include "haptics/devices/spacemouse.h"
#include "haptics/devices/woodenhaptics.h"
#endif
#include "patient/patient.h"

namespace stylet::haptics {

using patient::DataError;

namespace {

// A kind and what can be done with it; `make` is null where the build lacks its library.
struct Entry {
    DeviceKind kind;
    void (*find)(const DeviceOptions&, std::vector<FoundDevice>&);
    DeviceProfile (*profile)(const DeviceOptions&);
    std::unique_ptr<Driver> (*make)(const DeviceOptions&, const Clock&);
};

#ifdef STYLET_HIDAPI

constexpr const char* kNoHid = nullptr;

void addHid(std::vector<FoundDevice>& found, const char* kind, bool (*isOne)(const HidEntry&),
            const std::string& unless) {
    for (const HidEntry& entry : listHid()) {
        const bool known = std::any_of(found.begin(), found.end(),
                                       [&](const FoundDevice& f) { return f.place == entry.path; });
        if (!isOne(entry) || known) continue;
        std::array<char, 16> ids{};
        std::snprintf(ids.data(), ids.size(), "%04x:%04x", entry.vendor, entry.product);
        const std::string problem = accessProblem(entry.path);
        found.push_back(
            {kind, entry.path, entry.name + " (" + ids.data() + ")", problem.empty() ? unless : problem});
    }
}

void findWooden(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    addHid(found, "woodenhaptics", isWoodenBoard,
           options.model.empty() ? "its dimensions are needed: name the woodenhaptics.json of its maker's "
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
    DeviceProfile profile = profileOf(loadWoodenModel(options.model));
    profile.name = "woodenhaptics";
    return profile;
}

std::unique_ptr<Driver> makeWooden(const DeviceOptions& options, const Clock&) {
    return std::make_unique<WoodenHaptics>(woodenModel(options));
}

bool isCap(const HidEntry& entry) {
    return isSpaceMouse(entry.vendor, entry.product, entry.usage_page, entry.usage);
}
void findCaps(const DeviceOptions&, std::vector<FoundDevice>& found) {
    addHid(found, "spacemouse", isCap, "");
}
DeviceProfile capProfile(const DeviceOptions&) {
    return spaceMouseProfile();
}
std::unique_ptr<Driver> makeCap(const DeviceOptions&, const Clock& clock) {
    return std::make_unique<SpaceMouse>(clock);
}

#else

constexpr const char* kNoHid = "libhidapi-dev";
constexpr decltype(Entry::find) findWooden = nullptr, findCaps = nullptr;
constexpr decltype(Entry::profile) woodenProfile = nullptr, capProfile = nullptr;
constexpr decltype(Entry::make) makeWooden = nullptr, makeCap = nullptr;

#endif

std::string socketOf(const DeviceOptions& options) {
    return options.socket.empty() ? bridgeSocketPath() : options.socket;
}

void findBridge(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string socket = socketOf(options);
    std::error_code error;
    if (std::filesystem::is_socket(socket, error))
        found.push_back({"bridge", socket, "a bridge's socket", accessProblem(socket)});
}

DeviceProfile bridgeProfile(const DeviceOptions&) {
    return {.name = "bridge",
            .force_peak_n = kUnknown,
            .stiffness_n_per_m = kUnknown,
            .source = "the bridge tells once it is connected"};
}

std::unique_ptr<Driver> makeBridge(const DeviceOptions& options, const Clock&) {
    return std::make_unique<BridgeDriver>(BridgeSettings{.socket_path = socketOf(options)});
}

constexpr std::array kEntries{
    Entry{{"woodenhaptics", "WoodenHaptics or Polhem v1, open hardware (USB HID)", kNoHid},
          findWooden,
          woodenProfile,
          makeWooden},
    Entry{{"spacemouse", "SpaceMouse: moves the needle, gives no force (USB HID)", kNoHid},
          findCaps,
          capProfile,
          makeCap},
    Entry{{"bridge", "a device behind a closed SDK, in a process of its own", nullptr},
          findBridge,
          bridgeProfile,
          makeBridge},
};

constexpr auto kKinds = [] {
    std::array<DeviceKind, kEntries.size()> kinds{};
    for (std::size_t i = 0; i < kinds.size(); ++i)
        kinds[i] = kEntries[i].kind;
    return kinds;
}();

const Entry& usable(std::string_view name) {
    std::string names;
    for (const Entry& entry : kEntries) {
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
    return kKinds;
}

std::vector<FoundDevice> findDevices(const DeviceOptions& options) {
    std::vector<FoundDevice> found;
    for (const Entry& entry : kEntries)
        if (entry.find) entry.find(options, found);
    return found;
}

DeviceProfile profileOfKind(std::string_view kind, const DeviceOptions& options) {
    return usable(kind).profile(options);
}

std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions& options, const Clock& clock) {
    return usable(kind).make(options, clock);
}

}  // namespace stylet::haptics
