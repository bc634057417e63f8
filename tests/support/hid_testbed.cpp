#include "tests/support/hid_testbed.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "tests/support/wait_until.h"

namespace stylet::test {

namespace {

std::string toHex(const std::vector<unsigned char>& bytes) {
    std::string text;
    for (const unsigned char byte : bytes)
        text += fmt::format("{:02X}", byte);
    return text;
}

// Returns the paths below /sys of a USB device with one HID interface: device, interface, HID, hidraw node.
std::array<std::string, 4> sysfsPaths(const HidIdentity& id, int number) {
    const std::string usb = fmt::format("/devices/usb1/1-{}", number + 1);
    const std::string interface = fmt::format("{}/1-{}:1.0", usb, number + 1);
    const std::string hid =
        fmt::format("{}/0003:{:04X}:{:04X}.{:04X}", interface, id.vendor, id.product, number + 1);
    return {usb, interface, hid, fmt::format("{}/hidraw/hidraw{}", hid, number)};
}

// Returns the kernel's description of these four devices in umockdev's notation.
std::string describe(const HidIdentity& id, int number) {
    const auto [usb, interface, hid, raw] = sysfsPaths(id, number);
    const std::string node = "hidraw" + std::to_string(number);
    const std::string hid_id = fmt::format("HID_ID=0003:{:08X}:{:08X}", id.vendor, id.product);
    return fmt::format(
               "P: {}\nN: {}\nE: DEVNAME=/dev/{}\nE: SUBSYSTEM=hidraw\nE: MAJOR=247\nE: MINOR={}\n"
               "L: device=../../../{}\n\n",
               raw, node, node, number, hid.substr(hid.rfind('/') + 1)) +
           fmt::format(
               "P: {0}\nE: SUBSYSTEM=hid\nE: DRIVER=hid-generic\nE: {1}\nE: HID_NAME={2}\nE: HID_UNIQ=\n"
               "H: report_descriptor={3}\n"
               "A: uevent=DRIVER=hid-generic\\n{1}\\nHID_NAME={2}\\nHID_UNIQ=\\n\n\n",
               hid, hid_id, id.name, toHex(id.report_descriptor)) +
           fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=00\n\n",
                       interface) +
           fmt::format(
               "P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: idVendor={:04x}\nA: idProduct={:04x}\n"
               "A: manufacturer={}\nA: product={}\nA: bcdDevice=0100\n\n",
               usb, id.vendor, id.product, id.maker, id.name);
}

// Answers the only ioctl that hidapi needs from a node: the size of its report descriptor.
gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer size) {
    if (umockdev_ioctl_client_get_request(client) != HIDIOCGRDESCSIZE) return FALSE;
    UMockdevIoctlData* to =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(int), nullptr);
    int value = *static_cast<std::atomic<int>*>(size);
    umockdev_ioctl_data_update(to, 0, reinterpret_cast<guint8*>(&value), sizeof value);
    g_object_unref(to);
    umockdev_ioctl_client_complete(client, 0, 0);
    return TRUE;
}

}  // namespace

// There is one testbed per process, because umockdev redirects the system calls of the whole process to it.
struct HidNode::Testbed {
    UMockdevTestbed* bed = umockdev_testbed_new();
    UMockdevIoctlBase* handler = umockdev_ioctl_base_new();
    std::atomic<int> descriptor_size{0};  // read on umockdev's thread
    int plugged = 0;  // total so far; needed because umockdev does not accept a number twice

    Testbed() { g_signal_connect(handler, "handle-ioctl", G_CALLBACK(onIoctl), &descriptor_size); }
    ~Testbed() {
        g_object_unref(handler);
        g_object_unref(bed);
    }
    // Attach the handler first, so that a driver never finds a device without a handler.
    void add(const HidIdentity& id, int number, const std::string& path) {
        GError* error = nullptr;
        descriptor_size = int(id.report_descriptor.size());
        if (umockdev_testbed_attach_ioctl(bed, path.c_str(), handler, &error) &&
            umockdev_testbed_add_from_string(bed, describe(id, number).c_str(), &error))
            return;
        throw std::runtime_error(error->message);
    }

    static Testbed& shared() {
        static Testbed testbed;
        return testbed;
    }
};

bool underUmockdev() {
    const char* preload = std::getenv("LD_PRELOAD");
    return preload && std::strstr(preload, "libumockdev-preload");
}

HidNode::HidNode(const HidIdentity& id) : testbed_(&Testbed::shared()) {
    const int number = testbed_->plugged++;
    path_ = "/dev/hidraw" + std::to_string(number);
    for (const std::string& place : sysfsPaths(id, number))
        sys_paths_.push_back("/sys" + place);
    testbed_->add(id, number, path_);
    far_ = umockdev_testbed_get_dev_fd(testbed_->bed, path_.c_str());
    termios raw{};
    tcgetattr(far_, &raw);
    cfmakeraw(&raw);
    tcsetattr(far_, TCSANOW, &raw);
    near_ = ioctl(far_, TIOCGPTPEER, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    // A program that the test starts must not inherit this end.
    fcntl(far_, F_SETFD, FD_CLOEXEC);
    if (near_ < 0) throw std::runtime_error("the node has no other end");
}

HidNode::~HidNode() {
    unplug();
}

// Waits for the previous report to be read, so that two reports never arrive as one.
bool HidNode::send(std::span<const unsigned char> report) {
    const bool read = waitUntil([&] { return far_ < 0 || waiting() == 0; }, std::chrono::seconds(1));
    return far_ >= 0 && read && write(far_, report.data(), report.size()) == ssize_t(report.size());
}

// A kernel thread delivers what was written to a terminal, late on a busy machine, and the queue looks empty
// until then. poll() waits for that delivery.
int HidNode::waiting() const {
    pollfd unread{near_, POLLIN, 0};
    int bytes = 0;
    return poll(&unread, 1, 0) >= 0 && ioctl(near_, FIONREAD, &bytes) == 0 ? bytes : 0;
}

std::optional<std::vector<unsigned char>> HidNode::receive(std::size_t bytes, int timeout_ms) {
    while (pending_.size() < bytes) {
        pollfd waiting{far_, POLLIN, 0};
        if (far_ < 0 || poll(&waiting, 1, timeout_ms) <= 0) return std::nullopt;
        unsigned char chunk[256];
        const ssize_t count = read(far_, chunk, sizeof chunk);
        if (count <= 0) return std::nullopt;
        pending_.insert(pending_.end(), chunk, chunk + count);
    }
    const auto end = pending_.begin() + std::ptrdiff_t(bytes);
    std::vector<unsigned char> taken(pending_.begin(), end);
    pending_.erase(pending_.begin(), end);
    return taken;
}

void HidNode::block() {
    const unsigned char filler = 0;
    while (write(near_, &filler, 1) == 1) {
    }
}

void HidNode::unplug() {
    if (far_ < 0) return;
    close(near_);
    close(far_);
    near_ = far_ = -1;
    // umockdev does not remove a device's children with it. Remove the node first, then its parents.
    for (; !sys_paths_.empty(); sys_paths_.pop_back())
        umockdev_testbed_remove_device(testbed_->bed, sys_paths_.back().c_str());
}

}  // namespace stylet::test
