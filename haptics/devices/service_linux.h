// Services on this machine, without asking them anything.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace stylet::haptics {

// Does any program listen on this TCP port?
bool listensOn(std::uint16_t port);
// The same by the text of /proc/net/tcp or tcp6.
bool listensOn(std::uint16_t port, std::string_view proc_net_tcp);

// Does any program listen on this UNIX socket? The file alone is left behind by one that died.
bool listensOn(const std::string& socket);
// The same by the text of /proc/net/unix.
bool listensOn(const std::string& socket, std::string_view proc_net_unix);

}  // namespace stylet::haptics
