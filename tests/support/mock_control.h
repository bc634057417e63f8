// Client of the mock runtime's control socket (xr/mock/SCENARIO.md). It runs outside the application.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

namespace stylet::test {

class MockControl {
  public:
    // Waits until the runtime listens. Throws std::runtime_error after `patience`.
    explicit MockControl(const std::string& path, std::chrono::seconds patience = std::chrono::seconds(60)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
        const auto deadline = std::chrono::steady_clock::now() + patience;
        for (;;) {
            socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
            if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return;
            ::close(socket_);
            if (std::chrono::steady_clock::now() > deadline)
                throw std::runtime_error("nobody listens on " + path);
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
    ~MockControl() { ::close(socket_); }
    MockControl(const MockControl&) = delete;
    MockControl& operator=(const MockControl&) = delete;

    // Sends a request and waits until the application handles it. Returns the reply. Throws
    // std::runtime_error if the request is refused or the connection is closed.
    nlohmann::json sendRequest(const nlohmann::json& request) {
        const std::string line = request.dump() + "\n";
        for (std::size_t sent = 0; sent < line.size();) {
            const ssize_t count = ::send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
            if (count <= 0) throw std::runtime_error("the runtime is gone");
            sent += std::size_t(count);
        }
        while (in_.find('\n') == std::string::npos) {
            char buffer[4096];
            const ssize_t count = ::recv(socket_, buffer, sizeof buffer, 0);
            if (count <= 0) throw std::runtime_error("the runtime is gone");
            in_.append(buffer, std::size_t(count));
        }
        const std::size_t end = in_.find('\n');
        const auto reply = nlohmann::json::parse(in_.substr(0, end));
        in_.erase(0, end + 1);
        if (!reply.at("ok").get<bool>()) throw std::runtime_error(reply.at("error").get<std::string>());
        return reply;
    }

  private:
    int socket_ = -1;
    std::string in_;
};

}  // namespace stylet::test
