#include "haptics/devices/hid_port.h"

#include <hidapi/hidapi.h>

#include <fmt/core.h>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "haptics/devices/permission_linux.h"

namespace stylet::haptics {

namespace {

// hidapi's device list and last error are process-wide.
std::mutex g_library;

std::string narrow(const wchar_t* text) {
    std::string out;
    for (; text && *text; ++text)
        out += *text >= 0x20 && *text < 0x7F ? char(*text) : '?';
    return out;
}

}  // namespace

std::vector<HidEntry> listHid() {
    const std::lock_guard lock(g_library);
    std::vector<HidEntry> entries;
    hid_device_info* const first = hid_enumerate(0, 0);
    for (const hid_device_info* d = first; d; d = d->next)
        entries.push_back({d->path ? d->path : "", narrow(d->product_string), d->vendor_id, d->product_id,
                           d->usage_page, d->usage});
    hid_free_enumeration(first);
    return entries;
}

void findHid(std::vector<FoundDevice>& found, const char* kind, bool (*isOne)(const HidEntry&),
             const std::string& problem) {
    for (const HidEntry& entry : listHid()) {
        const bool known = std::any_of(found.begin(), found.end(),
                                       [&](const FoundDevice& f) { return f.place == entry.path; });
        if (!isOne(entry) || known) continue;
        std::array<char, 16> ids{};
        std::snprintf(ids.data(), ids.size(), "%04x:%04x", entry.vendor, entry.product);
        const std::string denied = accessProblem(entry.path);
        found.push_back(
            {kind, entry.path, entry.name + " (" + ids.data() + ")", denied.empty() ? problem : denied});
    }
}

bool HidPort::open(const std::string& path, std::string& why) {
    close();
    const std::lock_guard lock(g_library);
    errno = 0;
    device_ = hid_open_path(path.c_str());
    if (!device_) why = accessProblem(path, errno);
    path_ = path;
    return isOpen();
}

bool HidPort::write(std::span<const unsigned char> report, std::string& why) {
    errno = 0;
    const int written = hid_write(device_, report.data(), report.size());
    if (written == int(report.size())) return true;
    why = written < 0 ? fmt::format("{} does not accept reports: {}", path_, std::strerror(errno))
                      : fmt::format("{} accepted only {} bytes of a report", path_, written);
    return false;
}

int HidPort::read(std::span<unsigned char> into, int timeout_ms, std::string& why) {
    errno = 0;
    const int bytes = hid_read_timeout(device_, into.data(), into.size(), timeout_ms);
    if (bytes >= 0) return bytes;
    if (errno == EINTR) return 0;
    why = fmt::format("{} was lost: {}", path_, errno != 0 ? std::strerror(errno) : "was it unplugged?");
    return -1;
}

void HidPort::close() noexcept {
    if (device_) hid_close(device_);
    device_ = nullptr;
}

}  // namespace stylet::haptics
