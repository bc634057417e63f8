#include "haptics/devices/hid_port.h"

#include <hidapi/hidapi.h>

#include <cerrno>
#include <cstring>
#include <mutex>

#include "haptics/devices/permission_linux.h"

namespace stylet::haptics {

namespace {

// hidapi's device list and last error are process-wide.
std::mutex& libraryMutex() {
    static std::mutex mutex;
    return mutex;
}

std::string narrow(const wchar_t* text) {
    std::string out;
    for (; text && *text; ++text)
        out += *text >= 0x20 && *text < 0x7F ? char(*text) : '?';
    return out;
}

}  // namespace

std::vector<HidEntry> listHid() {
    const std::lock_guard lock(libraryMutex());
    std::vector<HidEntry> entries;
    hid_device_info* const first = hid_enumerate(0, 0);
    for (const hid_device_info* d = first; d; d = d->next)
        entries.push_back({d->path ? d->path : "", narrow(d->product_string), d->vendor_id, d->product_id,
                           d->usage_page, d->usage});
    hid_free_enumeration(first);
    return entries;
}

bool HidPort::open(const std::string& path, std::string& why) {
    close();
    const std::lock_guard lock(libraryMutex());
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
    why = path_ + (written < 0 ? std::string(" does not accept reports: ") + std::strerror(errno)
                               : " accepted only " + std::to_string(written) + " bytes of a report");
    return false;
}

int HidPort::read(std::span<unsigned char> into, int timeout_ms, std::string& why) {
    errno = 0;
    const int bytes = hid_read_timeout(device_, into.data(), into.size(), timeout_ms);
    if (bytes >= 0) return bytes;
    if (errno == EINTR) return 0;
    why = path_ + " was lost" + (errno != 0 ? std::string(": ") + std::strerror(errno) : "; unplugged?");
    return -1;
}

void HidPort::close() noexcept {
    if (device_) hid_close(device_);
    device_ = nullptr;
}

}  // namespace stylet::haptics
