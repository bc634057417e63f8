#include "tests/support/falcon_testbed.h"

#include <fmt/core.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace stylet::test {

namespace {

constexpr const char* kSysPath = "/sys/devices/pci0000:00/0000:00:14.0/usb1/1-3";

std::string node(int device) {
    return fmt::format("bus/usb/001/{:03}", device);
}

// Descriptors of the device, its configuration, one vendor-specific interface and two bulk endpoints of
// 64 bytes: IN 0x81 and OUT 0x02.
constexpr const char* kDescriptors =
    "12010002000000080304"
    "48CB"
    "000401020301"
    "0902200001010080FA"
    "0904000002FFFFFF02"
    "07058102400000"
    "07050202400000";

std::string description(int device) {
    return fmt::format(
        "P: /devices/pci0000:00/0000:00:14.0/usb1/1-3\nN: {0}\n"
        "E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM={1}\n"
        "E: PRODUCT=403/cb48/400\nE: DEVNAME=/dev/{0}\n"
        "A: busnum=1\\n\nA: devnum={1}\\n\nA: devpath=3\\n\nA: speed=12\\n\n"
        "A: bConfigurationValue=1\\n\nA: idVendor=0403\\n\nA: idProduct=cb48\\n\nH: descriptors={2}\n",
        node(device), device, kDescriptors);
}

void check(GError* error) {
    if (!error) return;
    const std::string text = error->message;
    g_error_free(error);
    throw std::runtime_error("umockdev: " + text);
}

UMockdevIoctlData* resolve(UMockdevIoctlData* data, std::size_t offset, std::size_t size) {
    GError* error = nullptr;
    UMockdevIoctlData* const found = umockdev_ioctl_data_resolve(data, offset, size, &error);
    check(error);
    return found;
}

std::int64_t nowNs() {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

// A transfer that the client has submitted but not yet reaped.
struct FalconTestbed::Urb {
    UMockdevIoctlData* data = nullptr;
    UMockdevIoctlData* buffer = nullptr;
    unsigned char type = 0, endpoint = 0;
    std::uint64_t order = 0;
    std::int64_t since_ns = 0;
    bool discarded = false, done = false;
    ~Urb() {
        if (buffer) g_object_unref(buffer);
        if (data) g_object_unref(data);
    }
    std::span<std::uint8_t> bytes() const { return {buffer->data, std::size_t(buffer->data_len)}; }
    // Returns true, so that finish() can return the result.
    bool end(int status, int length) {
        put(offsetof(usbdevfs_urb, status), status);
        put(offsetof(usbdevfs_urb, actual_length), length);
        return true;
    }
    void put(std::size_t offset, int value) {
        umockdev_ioctl_data_update(data, offset, reinterpret_cast<std::uint8_t*>(&value), sizeof value);
    }
};

bool FalconTestbed::works() {
    UMockdevTestbed* const bed = umockdev_testbed_new();
    const bool mocked = umockdev_in_mock_environment();
    g_object_unref(bed);
    return mocked;
}

FalconTestbed::FalconTestbed(bool has_firmware)
    : falcon_(has_firmware), testbed_(umockdev_testbed_new()), handler_(umockdev_ioctl_base_new()) {
    g_signal_connect_data(handler_, "handle-ioctl", reinterpret_cast<GCallback>(&FalconTestbed::onRequest),
                          this, nullptr, GConnectFlags(0));
}

FalconTestbed::~FalconTestbed() {
    if (plugged_) plugOut();
    g_object_unref(testbed_);
    g_object_unref(handler_);
}

void FalconTestbed::plugIn() {
    GError* error = nullptr;
    umockdev_testbed_add_from_string(testbed_, description(++devices_).c_str(), &error);
    check(error);
    umockdev_testbed_attach_ioctl(testbed_, ("/dev/" + node(devices_)).c_str(), handler_, &error);
    check(error);
    umockdev_testbed_uevent(testbed_, kSysPath, "add");
    plugged_ = true;
}

void FalconTestbed::plugOut() {
    with([](FalconEmulator& falcon) { falcon.faults.unplugged = true; });
    umockdev_testbed_uevent(testbed_, kSysPath, "remove");
    GError* error = nullptr;
    umockdev_testbed_detach_ioctl(testbed_, ("/dev/" + node(devices_)).c_str(), &error);
    umockdev_testbed_remove_device(testbed_, kSysPath);
    plugged_ = false;
    check(error);
}

int FalconTestbed::onRequest(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
    static_cast<FalconTestbed*>(self)->handle(client);
    return 1;
}

// Runs on umockdev's thread.
void FalconTestbed::handle(UMockdevIoctlClient* client) {
    const std::lock_guard lock(mutex_);
    const unsigned long request = umockdev_ioctl_client_get_request(client);
    if (falcon_.faults.unplugged && request != USBDEVFS_REAPURBNDELAY && request != USBDEVFS_DISCARDURB)
        return umockdev_ioctl_client_complete(client, -1, ENODEV);
    switch (request) {
        case USBDEVFS_GET_CAPABILITIES: {
            UMockdevIoctlData* const data = resolve(umockdev_ioctl_client_get_arg(client), 0, 4);
            std::uint32_t can = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
            umockdev_ioctl_data_update(data, 0, reinterpret_cast<std::uint8_t*>(&can), sizeof can);
            g_object_unref(data);
            return umockdev_ioctl_client_complete(client, 0, 0);
        }
        case USBDEVFS_GETDRIVER:
            return umockdev_ioctl_client_complete(client, -1, ENODATA);
        case USBDEVFS_CLAIMINTERFACE:
        case USBDEVFS_RELEASEINTERFACE:
        case USBDEVFS_DISCONNECT_CLAIM:
        case USBDEVFS_CLEAR_HALT:
            return umockdev_ioctl_client_complete(client, 0, 0);
        case USBDEVFS_SUBMITURB:
            return submit(client);
        case USBDEVFS_REAPURBNDELAY:
            return reap(client);
        case USBDEVFS_DISCARDURB: {
            std::uint64_t address = 0;
            std::memcpy(&address, umockdev_ioctl_client_get_arg(client)->data, sizeof(void*));
            const auto found = urbs_.find(address);
            if (found == urbs_.end()) return umockdev_ioctl_client_complete(client, -1, EINVAL);
            found->second->discarded = true;
            return umockdev_ioctl_client_complete(client, 0, 0);
        }
        default:
            return umockdev_ioctl_client_complete(client, -1, ENOTTY);
    }
}

void FalconTestbed::submit(UMockdevIoctlClient* client) {
    auto urb = std::make_unique<Urb>();
    urb->data = resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_urb));
    urb->type = urb->data->data[offsetof(usbdevfs_urb, type)];
    urb->endpoint = urb->data->data[offsetof(usbdevfs_urb, endpoint)];
    int length = 0;
    std::memcpy(&length, urb->data->data + offsetof(usbdevfs_urb, buffer_length), sizeof length);
    urb->buffer = resolve(urb->data, offsetof(usbdevfs_urb, buffer), std::size_t(length));
    urb->order = ++submitted_;
    urb->since_ns = nowNs();
    // Complete control and OUT transfers at once, as a real device does. Otherwise a client that stalls
    // before reaping could cancel data that it has already sent.
    urb->done = (urb->type == USBDEVFS_URB_TYPE_CONTROL || urb->endpoint != 0x81) && finish(*urb);
    const std::uint64_t address = urb->data->client_addr;
    urbs_[address] = std::move(urb);
    umockdev_ioctl_client_complete(client, 0, 0);
}

void FalconTestbed::reap(UMockdevIoctlClient* client) {
    Urb* done = nullptr;
    for (auto& [address, urb] : urbs_)
        if ((!done || urb->order < done->order) && finish(*urb)) done = urb.get();
    if (!done) {
        // Sleep first, because libusb retries immediately.
        std::this_thread::sleep_for(std::chrono::microseconds(100));
        umockdev_ioctl_client_complete(client, -1, falcon_.faults.unplugged ? ENODEV : EAGAIN);
        return;
    }
    UMockdevIoctlData* const pointer = resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(void*));
    umockdev_ioctl_data_set_ptr(pointer, 0, done->data);
    g_object_unref(pointer);
    const std::uint64_t address = done->data->client_addr;
    umockdev_ioctl_client_complete(client, 0, 0);
    urbs_.erase(address);
}

// Completes the transfer if that is possible now. Returns true if it is complete.
bool FalconTestbed::finish(Urb& u) {
    if (u.done) return true;
    if (u.discarded) return u.end(-ENOENT, 0);
    if (falcon_.faults.unplugged) return u.end(-ENODEV, 0);
    const std::span<std::uint8_t> bytes = u.bytes();
    if (u.type == USBDEVFS_URB_TYPE_CONTROL) {
        // Setup packet: bmRequestType 0x40, bRequest, wValue, wIndex 0, wLength 0.
        if (bytes.size() != 8 || bytes[0] != 0x40 || bytes[4] || bytes[5] || bytes[6] || bytes[7])
            return u.end(-EPIPE, 0);
        falcon_.control(bytes[1], std::uint16_t(bytes[2] | bytes[3] << 8));
        return u.end(0, 0);
    }
    if (u.endpoint == 0x02) {
        if (falcon_.faults.deaf) return false;
        falcon_.bulkOut(bytes, nowNs());
        return falcon_.faults.unplugged ? u.end(-ENODEV, 0) : u.end(0, int(bytes.size()));
    }
    const bool due = nowNs() - u.since_ns >= falcon_.latencyMs() * 1'000'000LL;
    if (u.endpoint != 0x81 || bytes.size() != 64) return u.end(-EPIPE, 0);
    if (falcon_.faults.mute || (!falcon_.hasData() && !due)) return false;
    std::vector<std::uint8_t> packet = falcon_.bulkIn();
    umockdev_ioctl_data_update(u.buffer, 0, packet.data(), int(packet.size()));
    return u.end(0, int(packet.size()));
}

}  // namespace stylet::test
