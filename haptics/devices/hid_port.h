// HID devices through hidapi: lists those plugged in and opens one.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptics/devices/entry.h"

struct hid_device_;

namespace stylet::haptics {

struct HidEntry {
    std::string path, name;  // "/dev/hidraw0"; product name from the maker
    std::uint16_t vendor = 0, product = 0;
    std::uint16_t usage_page = 0, usage = 0;  // 0: the descriptor could not be read
};

// Any thread.
std::vector<HidEntry> listHid();

// Appends the devices for which `isOne` returns true. `problem` is stored with each device that can be
// accessed; for the others the access problem is stored.
void findHid(std::vector<FoundDevice>& found, const char* kind, bool (*isOne)(const HidEntry&),
             const std::string& problem);

// One thread at a time.
class HidPort {
  public:
    HidPort() = default;
    ~HidPort() { close(); }
    HidPort(const HidPort&) = delete;
    HidPort& operator=(const HidPort&) = delete;

    // Returns false with a reason in `why`, and a remedy if there is one.
    bool open(const std::string& path, std::string& why);
    bool isOpen() const noexcept { return device_ != nullptr; }
    // Writes a report that starts with its id. Returns false with `why` if it was not sent completely.
    bool write(std::span<const unsigned char> report, std::string& why);
    // Reads one report. Returns its length, 0 on timeout, or -1 with `why` if the device is gone.
    int read(std::span<unsigned char> into, int timeout_ms, std::string& why);
    void close() noexcept;

  private:
    hid_device_* device_ = nullptr;
    std::string path_;
};

}  // namespace stylet::haptics
