// A UNIX stream socket to a program of the same user, without blocking.
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
    // Of failed, `why`: the path, the system's reason, or that another user listens there (root may).
    Connected connect(const std::string& path, std::string& why);
    bool isOpen() const noexcept { return socket_ >= 0; }
    // Whole or not at all: who lets the socket fill up has been silent for long.
    bool sendWhole(std::span<const std::uint8_t>) noexcept;
    enum class Received : std::uint8_t { bytes, nothingYet, ended };
    // `got` is the part of `into` that was filled; of ended, `why`, empty where the other end closed it.
    Received receive(std::span<std::uint8_t> into, std::span<const std::uint8_t>& got, std::string& why);
    // Until there is something to receive, or so long.
    void waitReadable(std::int64_t for_ns) const noexcept;
    void close() noexcept;

  private:
    int socket_ = -1;
};

// The folder for sockets of this user: $XDG_RUNTIME_DIR, else /run/user/UID.
std::string userSocketFolder();

}  // namespace stylet::haptics
