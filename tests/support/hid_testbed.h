// HID devices that are not there: umockdev makes their sysfs entries and device nodes, and the test holds the
// other end of each node. Programs that use it run under umockdev-wrapper.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stylet::test {

struct HidIdentity {
    std::uint16_t vendor = 0, product = 0;
    std::string maker, name;
    std::vector<unsigned char> report_descriptor;
};

bool underUmockdev();

// A device plugged in; unplugged when it goes out of scope. One report is one write: the node is a terminal
// in raw mode, so the next is sent only when the driver has taken the last.
class HidNode {
  public:
    // `read_here`: the driver reads on the thread that sends. Then send() returns once the report waits
    // there.
    explicit HidNode(const HidIdentity&, bool read_here = false);
    ~HidNode();
    HidNode(const HidNode&) = delete;
    HidNode& operator=(const HidNode&) = delete;

    const std::string& path() const { return path_; }  // "/dev/hidraw0", the next number for the next
    // False when the driver does not take what was sent before within a second, or when it is unplugged.
    bool send(std::span<const unsigned char> report);
    // The next `bytes` of what the driver wrote, nothing within `timeout_ms`.
    std::optional<std::vector<unsigned char>> receive(std::size_t bytes, int timeout_ms);
    int waiting() const;  // bytes that the driver has not read yet
    // The driver's next write blocks, as it does while a device does not answer on its bus.
    void block();
    void unplug();

  private:
    struct Testbed;
    bool delivered(std::size_t bytes) const;
    Testbed* testbed_;
    std::string path_;
    std::vector<std::string> sys_paths_;
    const bool read_here_;
    int far_ = -1, near_ = -1;  // the test's end, the driver's end looked into
    std::vector<unsigned char> pending_;
    std::chrono::steady_clock::time_point delivered_{};
};

}  // namespace stylet::test
