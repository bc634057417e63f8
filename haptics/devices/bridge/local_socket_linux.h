// A non-blocking UNIX stream socket to a program of the same user.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace stylet::haptics {

class LocalSocket {
  public:
    LocalSocket() = default;
    ~LocalSocket() { close(); }
    LocalSocket(const LocalSocket&) = delete;
    LocalSocket& operator=(const LocalSocket&) = delete;

    enum class Connected : std::uint8_t { yes, nobodyListens, failed };
    // Connects only to a program of this user or of root. nobodyListens: no program has opened the socket
    // at `path`. failed: a system error, a path that is too long, or a listener of another user. Unless the
    // result is yes, `why` is the reason.
    Connected connect(const std::string& path, std::string& why);
    bool isOpen() const noexcept { return socket_ >= 0; }
    // Sends without waiting. Returns false unless the socket accepted all bytes. A full send buffer is an
    // error, because it means that the peer has not read for a long time.
    bool sendWhole(std::span<const std::uint8_t>) noexcept;
    enum class Received : std::uint8_t { bytes, nothingYet, ended };
    // `got` is the filled part of `into`. For `ended`, `why` is the reason, empty if the other end closed
    // the connection.
    Received receive(std::span<std::uint8_t> into, std::span<const std::uint8_t>& got, std::string& why);
    // Waits until data can be received, at most `for_ns`.
    void waitReadable(std::int64_t for_ns) const noexcept;
    void close() noexcept;

  private:
    int socket_ = -1;
};

// The user's folder for sockets: $XDG_RUNTIME_DIR, else /run/user/UID.
std::string userSocketFolder();

}  // namespace stylet::haptics
