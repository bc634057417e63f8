// Emulated HID devices. umockdev creates their sysfs entries and device nodes; the test has the other end of
// each node. Run programs that use it under umockdev-wrapper.
#pragma once

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

// A connected device; the destructor unplugs it. The node is a terminal in raw mode, which does not separate
// reports. So a report is sent, in one write, only after the driver has read the previous one.
class HidNode {
  public:
    explicit HidNode(const HidIdentity&);
    ~HidNode();
    HidNode(const HidNode&) = delete;
    HidNode& operator=(const HidNode&) = delete;

    const std::string& path() const { return path_; }  // "/dev/hidraw0"; each device gets a new number
    // False if the driver does not read the previous report within a second, or if the device is unplugged.
    bool send(std::span<const unsigned char> report);
    // Returns the next `bytes` bytes that the driver wrote, or nothing if they do not arrive in `timeout_ms`.
    std::optional<std::vector<unsigned char>> receive(std::size_t bytes, int timeout_ms);
    int waiting() const;  // bytes that the driver has not read yet
    // Makes the driver's next write block, as if the device did not answer on its bus.
    void block();
    void unplug();

  private:
    struct Testbed;
    Testbed* testbed_;
    std::string path_;
    std::vector<std::string> sys_paths_;
    int far_ = -1, near_ = -1;  // the test's end; the driver's end, to check what is unread
    std::vector<unsigned char> pending_;
};

}  // namespace stylet::test
