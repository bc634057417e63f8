#include "haptics/devices/entry.h"
#ifdef STYLET_INVERSE3
#include "haptics/devices/inverse3/inverse3.h"
#include "haptics/devices/inverse3/service_linux.h"
#endif

namespace stylet::haptics {

#ifdef STYLET_INVERSE3

namespace {

Inverse3Settings inverse3Settings(const DeviceOptions& options) {
    Inverse3Settings settings;
    settings.force_peak_n = options.force_peak_n;
    if (options.port) settings.port = *options.port;
    return settings;
}

void findInverse3(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::uint16_t port = inverse3Settings(options).port;
    if (hasListener(port))
        found.push_back(
            {"inverse3", "localhost:" + std::to_string(port), "Haply's service, by its port", ""});
}

DeviceProfile inverse3Profile(const DeviceOptions& options) {
    return Inverse3Driver({}, inverse3Settings(options)).profile();
}

std::unique_ptr<Driver> makeInverse3(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<Inverse3Driver>(clock, inverse3Settings(options));
}

}  // namespace

extern const DeviceEntry kInverse3Entry{
    {"inverse3", "Haply Inverse3 with VerseGrip, through Haply's service", nullptr},
    findInverse3,
    inverse3Profile,
    makeInverse3};

#else

extern const DeviceEntry kInverse3Entry{
    {"inverse3", "Haply Inverse3 with VerseGrip, through Haply's service", "libboost-dev"},
    nullptr,
    nullptr,
    nullptr};

#endif

}  // namespace stylet::haptics
