// XRMOCK_CONTROL: a Unix stream socket for clients that connect while the application runs. Requests and
// replies are lines of JSON. The control thread only transfers lines: requests queue until the application
// makes an OpenXR call, and replies queue until the client reads them. A client therefore never blocks the
// application.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace xrmock {

class Control {
  public:
    struct Request {
        std::uint64_t client;
        std::string line;
    };

    // Listens at the path and starts the thread. Throws std::runtime_error on failure.
    explicit Control(const std::string& path);
    // Disconnects all clients and removes the socket.
    ~Control();
    Control(const Control&) = delete;
    Control& operator=(const Control&) = delete;

    // Any thread. Costs one atomic exchange if there are no requests.
    std::vector<Request> popRequests();
    // Any thread. `line` has no line break. The reply is dropped if the client has disconnected or has too
    // many unread replies.
    void reply(std::uint64_t client, const std::string& line);
    // Any thread. False once the client has hung up.
    bool isConnected(std::uint64_t client);
    const std::string& path() const { return path_; }

  private:
    struct Client {
        int socket = -1;
        std::string in, out;
        std::size_t queued = 0;    // requests not yet returned by popRequests()
        bool read_closed = false;  // the client has stopped sending, but may still read
        bool closing = false;      // disconnected once `out` is sent
    };

    void run();
    void acceptClient();
    void receive(std::uint64_t id, Client& client);
    void queueLines(std::uint64_t id, Client& client);
    static void send(Client& client);
    void wake();

    std::string path_;
    int listener_ = -1, waker_ = -1;
    std::mutex mutex_;  // guards the members below
    std::map<std::uint64_t, Client> clients_;
    std::vector<Request> requests_;
    std::size_t request_bytes_ = 0;
    std::uint64_t last_client_ = 0;
    std::atomic<bool> has_requests_ = false, stopping_ = false;
    std::thread thread_;
};

}  // namespace xrmock
