#include "haptics/devices/bridge/local_socket_linux.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <fmt/core.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace stylet::haptics {

namespace {

// Only this user or root may be at the other end, because it can move a trainee's hand.
bool trusted(int socket) noexcept {
    ucred peer{};
    socklen_t size = sizeof peer;
    return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
           (peer.uid == geteuid() || peer.uid == 0);
}

}  // namespace

Descriptor::~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
}

bool makeAddress(const std::string& path, sockaddr_un& address, std::string& why) {
    address = {};
    address.sun_family = AF_UNIX;
    if (path.copy(address.sun_path, sizeof address.sun_path - 1) == path.size()) return true;
    why = path + ": too long for a socket's path: choose a shorter one";
    return false;
}

DeviceStage LocalSocket::connect(const std::string& path, std::string& why) {
    close();
    sockaddr_un address;
    if (!makeAddress(path, address, why)) return DeviceStage::failed;
    socket_ = Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (socket_ < 0) {
        why = fmt::format("a socket cannot be created: {}", std::strerror(errno));
        return DeviceStage::failed;
    }
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const bool absent = errno == ENOENT || errno == ECONNREFUSED;
        why = absent ? "no bridge listens on " + path : path + ": " + std::strerror(errno);
        close();
        return absent ? DeviceStage::absent : DeviceStage::failed;
    }
    if (trusted(socket_)) return DeviceStage::opening;
    close();
    why = path + ": another user listens there";
    return DeviceStage::failed;
}

bool LocalSocket::sendAll(std::span<const std::uint8_t> bytes) noexcept {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return sent == ssize_t(bytes.size());
}

LocalSocket::Received LocalSocket::receive(std::span<std::uint8_t> into, std::span<const std::uint8_t>& got,
                                           std::string& why) {
    ssize_t count = 0;
    do
        count = ::recv(socket_, into.data(), into.size(), MSG_DONTWAIT);
    while (count < 0 && errno == EINTR);
    got = into.first(std::size_t(count > 0 ? count : 0));
    if (count > 0) return Received::bytes;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Received::noData;
    why = count == 0 ? "" : std::strerror(errno);
    return Received::ended;
}

void LocalSocket::waitReadable(std::int64_t for_ns) const noexcept {
    pollfd wait{socket_, POLLIN, 0};
    const timespec limit{time_t(for_ns / 1'000'000'000), long(for_ns % 1'000'000'000)};
    ppoll(&wait, 1, &limit, nullptr);
}

std::string userSocketFolder() {
    const char* folder = std::getenv("XDG_RUNTIME_DIR");
    return folder ? folder : fmt::format("/run/user/{}", geteuid());
}

}  // namespace stylet::haptics
