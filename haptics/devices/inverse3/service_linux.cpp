#include "haptics/devices/inverse3/service_linux.h"

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

std::string readTable(const char* file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

}  // namespace

// Line format: number, local address and port in hexadecimal, remote ones, state; 0A is LISTEN (proc(5)).
bool hasListener(std::uint16_t port, std::string_view table) {
    std::istringstream lines{std::string(table)};
    for (std::string line; std::getline(lines, line);) {
        unsigned local_port = 0, state = 0;
        if (std::sscanf(line.c_str(), "%*s %*[0-9A-Fa-f]:%x %*s %x", &local_port, &state) == 2 &&
            state == 0x0A && local_port == port)
            return true;
    }
    return false;
}

bool hasListener(std::uint16_t port) {
    return hasListener(port, readTable("/proc/net/tcp")) || hasListener(port, readTable("/proc/net/tcp6"));
}

// Line format: number, references, protocol, flags, type, state, inode, path. Flag 0x10000 marks a listener
// (__SO_ACCEPTCON). The path is the one that the program bound, possibly relative to that program's folder.
bool hasListener(const std::string& socket, std::string_view table) {
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

bool hasListener(const std::string& socket) {
    return hasListener(socket, readTable("/proc/net/unix"));
}

}  // namespace stylet::haptics
