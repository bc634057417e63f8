#include "haptics/devices/falcon/falcon_usb.h"

#include <libusb.h>

#include <fmt/core.h>
#include <algorithm>
#include <cerrno>

#include "haptics/devices/permission_linux.h"

namespace stylet::haptics::falcon {

namespace {

constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xcb48;
constexpr unsigned char kOut = 0x02, kIn = 0x81;
// Number of bytes requested by each read from the device. According to libnifalcon, larger requests fail with
// libusb and smaller requests fail on other operating systems.
constexpr int kUsbPacketBytes = 64;
constexpr int kStatusBytes = 2;
constexpr unsigned kControlWait_ms = 20;

struct Context {
    libusb_context* usb = nullptr;
    int error = libusb_init(&usb);
    Context() = default;
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    ~Context() {
        if (error == 0) libusb_exit(usb);
    }
};

struct DeviceList {
    libusb_device** devices = nullptr;
    std::ptrdiff_t count;
    explicit DeviceList(libusb_context* usb) : count(libusb_get_device_list(usb, &devices)) {}
    DeviceList(const DeviceList&) = delete;
    DeviceList& operator=(const DeviceList&) = delete;
    ~DeviceList() {
        if (count >= 0) libusb_free_device_list(devices, 1);
    }
};

bool isFalcon(libusb_device* device) {
    libusb_device_descriptor d{};
    return libusb_get_device_descriptor(device, &d) == 0 && d.idVendor == kVendor && d.idProduct == kProduct;
}

UsbPlace usbPlace(libusb_device* device) {
    std::array<std::uint8_t, 8> ports{};
    const int depth = libusb_get_port_numbers(device, ports.data(), int(ports.size()));
    const int bus = libusb_get_bus_number(device);
    UsbPlace place{.port = fmt::format("{}", bus), .node = {}};
    for (int i = 0; i < depth; ++i)
        place.port += fmt::format("{}{}", i == 0 ? '-' : '.', ports[std::size_t(i)]);
    place.node = fmt::format("/dev/bus/usb/{:03}/{:03}", bus, libusb_get_device_address(device));
    return place;
}

// With a `node`, access problems are reported with their remedy.
std::string reason(const char* what, int error, const std::string& node = {}) {
    if (!node.empty() && error == LIBUSB_ERROR_ACCESS) return accessProblem(node, EACCES);
    if (!node.empty() && error == LIBUSB_ERROR_BUSY) return accessProblem(node, EBUSY);
    return fmt::format("{}: {}", what, libusb_error_name(error));
}

BusResult toBusResult(const char* what, int error, std::string& why) {
    if (error == 0) return BusResult::ok;
    if (error == LIBUSB_ERROR_TIMEOUT) return BusResult::late;
    why = error == LIBUSB_ERROR_NO_DEVICE ? "the Falcon was unplugged" : reason(what, error);
    return BusResult::lost;
}

class UsbBus final : public FtdiBus {
  public:
    explicit UsbBus(const std::string& port) : port_(port) {}
    ~UsbBus() override { close(); }
    UsbBus(const UsbBus&) = delete;
    UsbBus& operator=(const UsbBus&) = delete;

    DeviceStage open(std::string& why) override {
        close();
        if (context_.error != 0) return fail("libusb does not start", context_.error, why);
        const DeviceList list(context_.usb);
        if (list.count < 0) return fail("the USB devices cannot be listed", int(list.count), why);
        libusb_device** const end = list.devices + list.count;
        libusb_device** const found = std::find_if(list.devices, end, [&](libusb_device* d) {
            return isFalcon(d) && (port_.empty() || usbPlace(d).port == port_);
        });
        if (found == end) {
            why = "no Falcon (USB 0403:cb48) is plugged in";
            return DeviceStage::absent;
        }
        const std::string node = usbPlace(*found).node;
        if (const int error = libusb_open(*found, &handle_); error != 0)
            return fail("the Falcon cannot be opened", error, why, node);
        // Ignore the result: it is not supported everywhere, and no kernel driver claims this product.
        libusb_set_auto_detach_kernel_driver(handle_, 1);
        if (const int error = libusb_claim_interface(handle_, 0); error != 0) {
            libusb_close(handle_);
            handle_ = nullptr;
            return fail("the Falcon cannot be claimed", error, why, node);
        }
        return DeviceStage::opening;
    }

    BusResult control(std::uint8_t request, std::uint16_t value, std::string& why) override {
        if (!handle_) return closed(why);
        const int sent = libusb_control_transfer(handle_, LIBUSB_REQUEST_TYPE_VENDOR, request, value, 0,
                                                 nullptr, 0, kControlWait_ms);
        return toBusResult("the Falcon's FTDI chip cannot be configured", std::min(sent, 0), why);
    }

    BusResult write(std::span<const std::uint8_t> bytes, int wait_ms, std::string& why) override {
        if (!handle_) return closed(why);
        // Copy, because libusb wants a pointer to non-const data.
        std::array<unsigned char, kUsbPacketBytes> buffer{};
        if (bytes.size() > buffer.size()) return BusResult::late;
        std::copy(bytes.begin(), bytes.end(), buffer.begin());
        int sent = 0;
        const int error =
            libusb_bulk_transfer(handle_, kOut, buffer.data(), int(bytes.size()), &sent, unsigned(wait_ms));
        const BusResult result = toBusResult("the Falcon accepts no data", error, why);
        return result == BusResult::ok && sent != int(bytes.size()) ? BusResult::late : result;
    }

    BusResult read(BusBytes& got, int wait_ms, std::string& why) override {
        got.count = 0;
        if (!handle_) return closed(why);
        std::array<unsigned char, kUsbPacketBytes> buffer{};
        int count = 0;
        const int error =
            libusb_bulk_transfer(handle_, kIn, buffer.data(), kUsbPacketBytes, &count, unsigned(wait_ms));
        // Even after a timeout some bytes may have arrived.
        if (count > kStatusBytes) {
            got.count = std::size_t(count - kStatusBytes);
            std::copy_n(buffer.begin() + kStatusBytes, got.count, got.bytes.begin());
        }
        return toBusResult("the Falcon cannot be read", error, why);
    }

    void close() noexcept override {
        if (!handle_) return;
        libusb_release_interface(handle_, 0);
        libusb_close(handle_);
        handle_ = nullptr;
    }

  private:
    static DeviceStage fail(const char* what, int error, std::string& why, const std::string& node = {}) {
        why = reason(what, error, node);
        return DeviceStage::failed;
    }
    static BusResult closed(std::string& why) {
        why = "the Falcon is not open";
        return BusResult::lost;
    }

    Context context_;
    std::string port_;
    libusb_device_handle* handle_ = nullptr;
};

}  // namespace

std::unique_ptr<FtdiBus> usbBus(const std::string& port) {
    return std::make_unique<UsbBus>(port);
}

std::vector<UsbPlace> findFalcons() {
    std::vector<UsbPlace> places;
    const Context context;
    if (context.error != 0) return places;
    const DeviceList list(context.usb);
    for (std::ptrdiff_t i = 0; i < list.count; ++i)
        if (isFalcon(list.devices[i])) places.push_back(usbPlace(list.devices[i]));
    return places;
}

}  // namespace stylet::haptics::falcon
