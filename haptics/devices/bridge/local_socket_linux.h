// A non-blocking UNIX stream socket to a program of the same user.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "haptics/devices/driver.h"

struct sockaddr_un;

namespace stylet::haptics {

// Owns a file descriptor, or none if it is negative.
class Descriptor {
  public:
    explicit Descriptor(int fd = -1) noexcept : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~Descriptor();
    operator int() const noexcept { return fd_; }

  private:
    int fd_;
};

class LocalSocket {
  public:
    // Connects only to a program of this user or of root. Returns the stage of the device: `opening` after
    // connecting, because the device behind the socket is not ready yet; `absent` if no program has opened
    // the socket at `path`; `failed` for a system error, a path that is too long, or a listener of another
    // user. `why` is the reason if the result is not `opening`.
    DeviceStage connect(const std::string& path, std::string& why);
    bool isOpen() const noexcept { return socket_ >= 0; }
    // Sends without waiting. Returns false unless the socket accepted all bytes. A full send buffer is an
    // error, because it means that the peer has not read for a long time.
    bool sendAll(std::span<const std::uint8_t>) noexcept;
    enum class Received : std::uint8_t { bytes, noData, ended };
    // `got` is the filled part of `into`. For `ended`, `why` is the reason, empty if the other end closed
    // the connection.
    Received receive(std::span<std::uint8_t> into, std::span<const std::uint8_t>& got, std::string& why);
    // Waits until data can be received, at most `for_ns`.
    void waitReadable(std::int64_t for_ns) const noexcept;
    void close() noexcept { socket_ = Descriptor(); }

  private:
    Descriptor socket_;
};

// Sets `address` to the socket file `path`. Returns false with `why` if the path is too long.
bool makeAddress(const std::string& path, sockaddr_un& address, std::string& why);

// The user's folder for sockets: $XDG_RUNTIME_DIR, else /run/user/UID.
std::string userSocketFolder();

}  // namespace stylet::haptics
