#include "haptics/devices/inverse3/service_linux.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace stylet::haptics {

namespace {

// Resolves links to an absolute path. Returns the path unchanged if that fails.
std::string realPath(const std::string& path) {
    std::error_code error;
    const std::filesystem::path real = std::filesystem::weakly_canonical(path, error);
    return error ? path : real.string();
}

}  // namespace

// Line format: number, local address and port in hexadecimal, remote ones, state; 0A is LISTEN (proc(5)).
bool listensOn(std::uint16_t port, std::string_view table) {
    std::istringstream lines{std::string(table)};
    for (std::string line; std::getline(lines, line);) {
        std::array<char, 48> local{}, remote{};
        unsigned state = 0, local_port = 0;
        if (std::sscanf(line.c_str(), "%*s %47s %47s %x", local.data(), remote.data(), &state) != 3) continue;
        const std::string address = local.data();
        const std::size_t colon = address.rfind(':');
        if (colon == std::string::npos || std::sscanf(address.c_str() + colon + 1, "%x", &local_port) != 1)
            continue;
        if (state == 0x0A && local_port == port) return true;
    }
    return false;
}

bool listensOn(std::uint16_t port) {
    for (const char* file : {"/proc/net/tcp", "/proc/net/tcp6"}) {
        std::ostringstream text;
        text << std::ifstream(file).rdbuf();
        if (listensOn(port, text.str())) return true;
    }
    return false;
}

// Line format: number, references, protocol, flags, type, state, inode, path. Flag 0x10000 marks a listener
// (__SO_ACCEPTCON). The path is as its program gave it, possibly relative to that program's folder.
bool listensOn(const std::string& socket, std::string_view table) {
    const auto nameOf = [](const std::string& path) { return path.substr(path.rfind('/') + 1); };
    const std::string asked = realPath(socket);
    std::istringstream lines{std::string(table)};
    for (std::string line; std::getline(lines, line);) {
        unsigned flags = 0;
        int at = 0;
        if (std::sscanf(line.c_str(), "%*s %*s %*s %x %*s %*s %*s %n", &flags, &at) != 1 || at == 0) continue;
        const std::string path = line.substr(std::size_t(at));
        if ((flags & 0x10000u) == 0 || path.empty()) continue;
        const bool from_elsewhere = path[0] != '/' && path[0] != '@';
        if (path == socket) return true;
        // The socket file itself is not a link, but its folders may be.
        if (nameOf(path) == nameOf(asked) && (from_elsewhere || realPath(path) == asked)) return true;
    }
    return false;
}

bool listensOn(const std::string& socket) {
    std::ostringstream text;
    text << std::ifstream("/proc/net/unix").rdbuf();
    return listensOn(socket, text.str());
}

}  // namespace stylet::haptics
