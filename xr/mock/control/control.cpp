#include "control/control.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "scenario/json_fields.h"

namespace xrmock {

namespace {

constexpr std::size_t kMaxClients = 16;
constexpr std::size_t kMaxQueued = 256;             // requests per client; then reading from it pauses
constexpr std::size_t kMaxQueuedBytes = 16U << 20;  // requests of all clients; then reading pauses
constexpr std::size_t kMaxReplyBytes = 256U << 20;  // unread replies of a client; then it is disconnected

sockaddr_un makeAddress(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path)
        throw std::runtime_error("XRMOCK_CONTROL: " + path + ": longer than 107 bytes");
    path.copy(address.sun_path, path.size());
    return address;
}

int openSocket() {
    const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket < 0) throw std::runtime_error("XRMOCK_CONTROL: no socket is left");
    return socket;
}

// Removes the socket file of a killed run, recognised because no process listens on it.
void removeStale(const std::string& path, const sockaddr_un& address) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
    const int probe = openSocket();
    const bool refused = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
                         errno == ECONNREFUSED;
    ::close(probe);
    if (refused) ::unlink(path.c_str());
}

int listenAt(const std::string& path) {
    const sockaddr_un address = makeAddress(path);
    removeStale(path, address);
    const int socket = openSocket();
    const bool bound = ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    if (!bound || ::chmod(path.c_str(), S_IRUSR | S_IWUSR) != 0 || ::listen(socket, 8) != 0) {
        const std::string reason = std::strerror(errno);
        ::close(socket);
        throw std::runtime_error("XRMOCK_CONTROL: " + path + ": " + reason);
    }
    return socket;
}

}  // namespace

Control::Control(const std::string& path) : path_(path), listener_(listenAt(path)) {
    waker_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    // Block all signals in this thread, so that the application's threads receive them.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Control::~Control() {
    stopping_ = true;
    wake();
    thread_.join();
    for (auto& [id, client] : clients_) {
        send(client);
        ::close(client.socket);
    }
    ::close(waker_);
    ::close(listener_);
    ::unlink(path_.c_str());
}

std::vector<Control::Request> Control::popRequests() {
    if (!has_requests_.exchange(false)) return {};
    const std::lock_guard guard(mutex_);
    for (auto& [id, client] : clients_)
        client.queued = 0;
    request_bytes_ = 0;
    wake();  // resume reading from clients that had reached their limit
    return std::exchange(requests_, {});
}

void Control::reply(std::uint64_t id, const std::string& line) {
    const std::lock_guard guard(mutex_);
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    Client& client = found->second;
    client.out += line;
    client.out += '\n';
    if (client.out.size() > kMaxReplyBytes) {
        client.out.clear();
        client.closing = true;
    }
    wake();
}

bool Control::isConnected(std::uint64_t client) {
    const std::lock_guard guard(mutex_);
    return clients_.contains(client);
}

void Control::wake() {
    const std::uint64_t one = 1;
    // A failed write means that the counter is full: the thread is already awake.
    [[maybe_unused]] const auto written = ::write(waker_, &one, sizeof one);
}

void Control::run() {
    while (!stopping_) {
        std::vector<pollfd> watched{{waker_, POLLIN, 0}, {listener_, POLLIN, 0}};
        std::vector<std::uint64_t> ids;
        {
            const std::lock_guard guard(mutex_);
            if (clients_.size() >= kMaxClients) watched[1].events = 0;
            for (const auto& [id, client] : clients_) {
                const bool hears = !client.read_closed && !client.closing && client.queued < kMaxQueued &&
                                   request_bytes_ < kMaxQueuedBytes;
                const int events = (hears ? POLLIN : 0) | (client.out.empty() ? 0 : POLLOUT);
                watched.push_back({client.socket, static_cast<short>(events), 0});
                ids.push_back(id);
            }
        }
        if (::poll(watched.data(), watched.size(), -1) < 0) continue;
        std::uint64_t wakes = 0;
        [[maybe_unused]] const auto read = ::read(waker_, &wakes, sizeof wakes);
        const std::lock_guard guard(mutex_);
        if ((watched[1].revents & POLLIN) != 0) acceptClient();
        for (std::size_t i = 0; i < ids.size(); ++i) {
            Client& client = clients_.at(ids[i]);
            const int ready = watched[i + 2].revents;
            if ((ready & POLLIN) != 0) receive(ids[i], client);
            if ((ready & (POLLERR | POLLHUP)) != 0 && (ready & POLLIN) == 0) {
                client.out.clear();
                client.closing = true;
            }
            send(client);
            queueLines(ids[i], client);
        }
        std::erase_if(clients_, [](const auto& entry) {
            const Client& client = entry.second;
            const bool goes = client.closing && client.out.empty();
            if (goes) ::close(client.socket);
            return goes;
        });
    }
}

void Control::acceptClient() {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket >= 0) clients_[++last_client_].socket = socket;
}

void Control::receive(std::uint64_t id, Client& client) {
    char buffer[1 << 16];
    const ssize_t count = ::recv(client.socket, buffer, sizeof buffer, 0);
    if (count > 0) client.in.append(buffer, static_cast<std::size_t>(count));
    queueLines(id, client);
    const bool ended = count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR);
    if (client.in.size() > kMaxMessageBytes && client.in.find('\n') == std::string::npos) {
        client.out += "{\"error\":\"a request is larger than 1 MiB\"}\n";
        client.in.clear();
        client.closing = true;
    }
    if (ended) client.read_closed = true;
}

// Queues complete lines as requests, up to the limits.
void Control::queueLines(std::uint64_t id, Client& client) {
    std::size_t from = 0;
    while (client.queued < kMaxQueued && request_bytes_ < kMaxQueuedBytes) {
        const std::size_t end = client.in.find('\n', from);
        if (end == std::string::npos) break;
        if (end > from) {
            requests_.push_back({id, client.in.substr(from, end - from)});
            request_bytes_ += end - from;
            ++client.queued;
            has_requests_ = true;
        }
        from = end + 1;
    }
    client.in.erase(0, from);
}

void Control::send(Client& client) {
    while (!client.out.empty()) {
        const ssize_t count = ::send(client.socket, client.out.data(), client.out.size(), MSG_NOSIGNAL);
        if (count < 0) {
            if (errno != EAGAIN && errno != EINTR) {
                client.out.clear();
                client.closing = true;
            }
            return;
        }
        client.out.erase(0, static_cast<std::size_t>(count));
    }
}

}  // namespace xrmock
