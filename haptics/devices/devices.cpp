#include "haptics/devices/devices.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "haptics/devices/bridge/bridge.h"
#include "haptics/devices/falcon/falcon_firmware.h"
#include "haptics/devices/inverse3/service_linux.h"
#include "haptics/devices/permission_linux.h"
#include "haptics/devices/profiles.h"
#ifdef STYLET_LIBUSB
#include "haptics/devices/falcon/falcon.h"
#include "haptics/devices/falcon/falcon_usb.h"
#endif
#ifdef STYLET_INVERSE3
#include "haptics/devices/inverse3/inverse3.h"
#endif
#ifdef STYLET_HIDAPI
#include "haptics/devices/spacemouse/spacemouse.h"
#include "haptics/devices/woodenhaptics/woodenhaptics.h"
#endif
#include "patient/patient.h"

namespace stylet::haptics {

namespace {

// A device kind with its functions. `make` is null if the build lacks its library.
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
    DeviceProfile profile = profileOf(loadWoodenModel(options.model));
    profile.name = "woodenhaptics";
    return profile;
}

std::unique_ptr<Driver> makeWooden(const DeviceOptions& options, const Clock&) {
    return std::make_unique<WoodenHaptics>(woodenModel(options));
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

#ifdef STYLET_LIBUSB

constexpr const char* kNoUsb = nullptr;

// Lists the Falcons on USB without opening them. It is therefore unknown whether a Falcon already has its
// firmware. Without --firmware, the entry of an accessible Falcon says that it is needed.
void findFalconsThere(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string unless =
        options.firmware.empty() ? "it needs its firmware after each power-up: pass your copy with --firmware"
                                 : "";
    for (const falcon::UsbPlace& place : falcon::findFalcons()) {
        const std::string problem = accessProblem(place.node);
        found.push_back(
            {"falcon", place.node, "Novint Falcon at usb " + place.port, problem.empty() ? unless : problem});
    }
}

falcon::Calibration falconCalibration(const DeviceOptions& options) {
    return options.calibration.empty() ? falcon::Calibration{} : falcon::loadCalibration(options.calibration);
}

DeviceProfile falconProfile(const DeviceOptions& options) {
    return falcon::profileOf(falconCalibration(options));
}

std::unique_ptr<Driver> makeFalcon(const DeviceOptions& options, const Clock& clock) {
    falcon::Settings settings;
    if (!options.firmware.empty()) settings.firmware = falcon::loadFirmwareFile(options.firmware);
    settings.calibration = falconCalibration(options);
    return std::make_unique<falcon::FalconDriver>(falcon::usbBus(), clock, std::move(settings));
}

#else

constexpr const char* kNoUsb = "libusb-1.0-0-dev";
constexpr decltype(Entry::find) findFalconsThere = nullptr;
constexpr decltype(Entry::profile) falconProfile = nullptr;
constexpr decltype(Entry::make) makeFalcon = nullptr;

#endif

#ifdef STYLET_INVERSE3

constexpr const char* kNoBoost = nullptr;

Inverse3Settings inverse3Settings(const DeviceOptions& options) {
    Inverse3Settings settings;
    settings.force_peak_n = options.force_peak_n;
    if (options.port) settings.port = *options.port;
    return settings;
}

void findInverse3(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::uint16_t port = inverse3Settings(options).port;
    if (listensOn(port))
        found.push_back(
            {"inverse3", "localhost:" + std::to_string(port), "Haply's service, by its port", ""});
}

DeviceProfile inverse3Profile(const DeviceOptions& options) {
    return Inverse3Driver({}, inverse3Settings(options)).profile();
}

std::unique_ptr<Driver> makeInverse3(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<Inverse3Driver>(clock, inverse3Settings(options));
}

#else

constexpr const char* kNoBoost = "libboost-dev";
constexpr decltype(Entry::find) findInverse3 = nullptr;
constexpr decltype(Entry::profile) inverse3Profile = nullptr;
constexpr decltype(Entry::make) makeInverse3 = nullptr;

#endif

std::string socketOf(const DeviceOptions& options) {
    return options.socket.empty() ? bridgeSocketPath() : options.socket;
}

void findBridge(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string socket = socketOf(options);
    std::error_code error;
    if (!std::filesystem::is_socket(socket, error)) return;
    std::string problem = accessProblem(socket);
    if (problem.empty() && !listensOn(socket))
        problem = "stale socket, no program listens: start the bridge again";
    found.push_back({"bridge", socket, "a bridge's socket", problem});
}

DeviceProfile bridgeProfile(const DeviceOptions&) {
    return {.name = "bridge",
            .force_peak_n = kUnknown,
            .stiffness_n_per_m = kUnknown,
            .source = "the bridge tells once it is connected"};
}

std::unique_ptr<Driver> makeBridge(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<BridgeDriver>(clock, BridgeSettings{.socket_path = socketOf(options)});
}

constexpr std::array kEntries{
    Entry{{"falcon", "Novint Falcon (USB)", kNoUsb}, findFalconsThere, falconProfile, makeFalcon},
    Entry{{"woodenhaptics", "WoodenHaptics or Polhem v1, open hardware (USB HID)", kNoHid},
          findWooden,
          woodenProfile,
          makeWooden},
    Entry{{"spacemouse", "SpaceMouse: moves the needle, gives no force (USB HID)", kNoHid},
          findCaps,
          capProfile,
          makeCap},
    Entry{{"inverse3", "Haply Inverse3 with VerseGrip, through Haply's service", kNoBoost},
          findInverse3,
          inverse3Profile,
          makeInverse3},
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

std::string firmwareDigest(const DeviceOptions& options) {
    return options.firmware.empty() ? "" : falcon::loadFirmwareFile(options.firmware).sha256;
}

std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions& options, const Clock& clock) {
    return usable(kind).make(options, clock);
}

}  // namespace stylet::haptics
