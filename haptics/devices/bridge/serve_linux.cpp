#include "haptics/devices/bridge/serve_linux.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>

#include "haptics/devices/bridge/bridge.h"

namespace stylet::haptics::bridge {

std::int64_t monotonic_ns() noexcept {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

namespace {

// Listens on `path` for this user only. Replaces a socket that nobody listens on.
Descriptor listenOn(const std::string& path, std::string& why) {
    sockaddr_un address;
    if (!makeAddress(path, address, why)) return Descriptor();
    const auto* generic = reinterpret_cast<const sockaddr*>(&address);

    const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (::connect(probe, generic, sizeof address) == 0) {
        why = path + ": another bridge listens there";
        return Descriptor();
    }
    // A plain file also refuses the connection, but it must not be deleted.
    struct stat there{};
    if (errno == ECONNREFUSED && ::lstat(path.c_str(), &there) == 0 && S_ISSOCK(there.st_mode))
        ::unlink(path.c_str());

    Descriptor listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const mode_t mask = ::umask(0077);
    const bool bound = ::bind(listener, generic, sizeof address) == 0 && ::listen(listener, 4) == 0;
    if (!bound) why = path + ": " + std::strerror(errno);
    ::umask(mask);
    return bound ? std::move(listener) : Descriptor();
}

class Server {
  public:
    Server(const Capabilities& capabilities, Servo& servo, Descriptor listener)
        : capabilities_(capabilities), servo_(servo), listener_(std::move(listener)) {}

    void run(const std::atomic<bool>& stop) {
        while (!stop.load() && !servo_.failure()) {
            pollfd waits[2] = {{listener_, POLLIN, 0}, {client_, POLLIN, 0}};
            if (::poll(waits, session_ ? 2 : 1, 20) <= 0) continue;
            if (waits[0].revents) accept();
            if (session_ && waits[1].revents && !readAndReply()) hangUp();
        }
        if (!session_) return;
        const char* why = servo_.failure();
        session_->end(why ? why : "the bridge was stopped", out_);
        flush();
        hangUp();
    }

  private:
    void accept() {
        Descriptor client(::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        if (client < 0) return;
        if (session_) {
            std::vector<std::uint8_t> out;
            Session(capabilities_, servo_).end("another trainer is connected", out);
            ::send(client, out.data(), out.size(), MSG_NOSIGNAL);
            return;
        }
        client_ = std::move(client);
        session_ = std::make_unique<Session>(capabilities_, servo_);
    }

    // One read per turn, so that a flooding trainer cannot keep run() from seeing `stop` or a device
    // failure.
    bool readAndReply() {
        std::uint8_t bytes[4096];
        const ssize_t got = ::recv(client_, bytes, sizeof bytes, 0);
        if (got < 0) return errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK;
        if (got == 0) return false;
        const bool on = session_->receive({bytes, std::size_t(got)}, out_);
        return flush() && on;
    }

    // A trainer that lets the socket fill up has stopped reading and is treated as gone.
    bool flush() {
        const ssize_t sent = ::send(client_, out_.data(), out_.size(), MSG_NOSIGNAL);
        const bool whole = sent == ssize_t(out_.size());
        out_.clear();
        return whole;
    }

    void hangUp() {
        servo_.release();
        session_.reset();
        client_ = Descriptor();
    }

    const Capabilities& capabilities_;
    Servo& servo_;
    Descriptor listener_, client_;
    std::unique_ptr<Session> session_;
    std::vector<std::uint8_t> out_;
};

std::atomic<bool> g_stop{false};

}  // namespace

std::string serve(Sdk& sdk, const std::string& socket_path, const std::atomic<bool>& stop) {
    std::string why;
    Descriptor listener = listenOn(socket_path, why);
    if (listener < 0) return why;
    Capabilities capabilities;
    Servo servo;
    if (sdk.open(capabilities, why) && sdk.start(servo, why)) {
        Server(capabilities, servo, std::move(listener)).run(stop);
        if (servo.failure()) why = servo.failure();
    }
    sdk.stop();
    ::unlink(socket_path.c_str());
    return why;
}

int bridgeMain(Sdk& sdk, int argc, char** argv) {
    std::string path = bridgeSocketPath();
    if (argc == 3 && std::strcmp(argv[1], "--socket") == 0) {
        path = argv[2];
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: %s [--socket PATH]\n", argv[0]);
        return 2;
    }
    for (const int number : {SIGINT, SIGTERM, SIGHUP})
        std::signal(number, [](int) { g_stop.store(true); });
    std::fprintf(stderr, "%s: on %s\n", argv[0], path.c_str());
    const std::string why = serve(sdk, path, g_stop);
    if (why.empty()) return 0;
    std::fprintf(stderr, "%s: %s\n", argv[0], why.c_str());
    return 1;
}

}  // namespace stylet::haptics::bridge
