// Detects services running on this machine without connecting to them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace stylet::haptics {

// True if any program listens on this TCP port.
bool hasListener(std::uint16_t port);
// The same, given the text of /proc/net/tcp or tcp6.
bool hasListener(std::uint16_t port, std::string_view proc_net_tcp);

// True if any program listens on this UNIX socket. A program that died leaves the file behind.
bool hasListener(const std::string& socket);
// The same, given the text of /proc/net/unix.
bool hasListener(const std::string& socket, std::string_view proc_net_unix);

}  // namespace stylet::haptics
