// XRMOCK_CONTROL: a Unix stream socket that clients connect to while the application runs; lines of JSON both
// ways. The thread here only moves lines: requests queue until the application makes a call, and replies
// until their client reads them, so that no client ever holds the application up.
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

    // Listens at the path and starts the thread. Throws std::runtime_error where that cannot be.
    explicit Control(const std::string& path);
    // Disconnects everybody and removes the socket.
    ~Control();
    Control(const Control&) = delete;
    Control& operator=(const Control&) = delete;

    // Any thread. Costs one atomic read where there is nothing.
    std::vector<Request> takeRequests();
    // Any thread. A line without its end; a client that went or that does not read loses it.
    void reply(std::uint64_t client, const std::string& line);
    // Any thread. False once the client has hung up.
    bool isConnected(std::uint64_t client);
    const std::string& path() const { return path_; }

  private:
    struct Client {
        int socket = -1;
        std::string in, out;
        std::size_t queued = 0;  // requests that were not taken yet
        bool deaf = false;       // it sends no more, but may still read
        bool leaving = false;    // goes once `out` is sent
    };

    void run();
    void acceptClient();
    void receive(std::uint64_t id, Client& client);
    void queueLines(std::uint64_t id, Client& client);
    static void send(Client& client);
    void wake();

    std::string path_;
    int listener_ = -1, waker_ = -1;
    std::mutex mutex_;  // of what follows
    std::map<std::uint64_t, Client> clients_;
    std::vector<Request> requests_;
    std::size_t request_bytes_ = 0;
    std::uint64_t last_client_ = 0;
    std::atomic<bool> has_requests_ = false, stopping_ = false;
    std::thread thread_;
};

}  // namespace xrmock
