#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdint>

#include "tests/fuzz/mock/mock_runtime.h"

namespace {

// An instance with a control channel, and a connection to that channel.
struct Run {
    Run() {
        const std::string path = mock_fuzz::scratchFile("s").string();
        setenv("XRMOCK_CONTROL", path.c_str(), 1);
        if (mock_fuzz::createInstance(&instance) != XR_SUCCESS) std::abort();
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        if (connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) std::abort();
    }
    ~Run() {
        close(socket);
        mock_fuzz::destroyInstance(instance);
    }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    // Polls until a reply that contains these bytes arrives.
    bool hears(const char* bytes) {
        std::string heard;
        for (int i = 0; i < 1'000'000 && heard.find(bytes) == std::string::npos; ++i) {
            if (mock_fuzz::poll(instance) == XR_ERROR_INSTANCE_LOST) return true;  // as requested
            char buffer[4096];
            const ssize_t count = recv(socket, buffer, sizeof buffer, MSG_DONTWAIT);
            if (count == 0) return false;
            if (count > 0) heard.append(buffer, static_cast<std::size_t>(count));
        }
        return heard.find(bytes) != std::string::npos;
    }

    XrInstance instance = XR_NULL_HANDLE;
    int socket = -1;
};

}  // namespace

// Whatever bytes a control client sends, the runtime still answers the next valid request.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Run run;
    std::string sent(reinterpret_cast<const char*>(data), size);
    sent += "\n{\"id\": \"after the fuzz\", \"get\": \"state\"}\n";
    if (send(run.socket, sent.data(), sent.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(sent.size()))
        return 0;
    if (!run.hears("after the fuzz")) std::abort();
    return 0;
}
