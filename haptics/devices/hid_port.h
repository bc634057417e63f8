// HID devices through hidapi: what is plugged in, and one of them opened.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

struct hid_device_;

namespace stylet::haptics {

struct HidEntry {
    std::string path, name;  // "/dev/hidraw0"; the maker's name for it
    std::uint16_t vendor = 0, product = 0;
    std::uint16_t usage_page = 0, usage = 0;  // 0: the descriptor could not be read
};

// Any thread.
std::vector<HidEntry> listHid();

// One thread at a time.
class HidPort {
  public:
    HidPort() = default;
    ~HidPort() { close(); }
    HidPort(const HidPort&) = delete;
    HidPort& operator=(const HidPort&) = delete;

    // False with a reason, and a remedy where there is one.
    bool open(const std::string& path, std::string& why);
    bool isOpen() const noexcept { return device_ != nullptr; }
    // A report with its id in front. False: it did not get there whole, and `why`.
    bool write(std::span<const unsigned char> report, std::string& why);
    // One report: its bytes. 0: none came in time. -1: the device is gone, and `why`.
    int read(std::span<unsigned char> into, int timeout_ms, std::string& why);
    void close() noexcept;

  private:
    hid_device_* device_ = nullptr;
    std::string path_;
};

}  // namespace stylet::haptics
