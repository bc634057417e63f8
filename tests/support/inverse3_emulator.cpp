#include "tests/support/inverse3_emulator.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace stylet::test {

namespace {

// Equals the default time that the drivers wait for an answer.
constexpr std::int64_t kLostInverse3Answer_ns = 4'000'000;

// SHA-1 of FIPS 180-4.
std::array<std::uint8_t, 20> sha1(std::string text) {
    const std::uint64_t bits = 8 * text.size();
    text += char(0x80);
    while (text.size() % 64 != 56)
        text += char(0);
    for (int shift = 56; shift >= 0; shift -= 8)
        text += char(bits >> shift & 0xFF);
    std::array<std::uint32_t, 5> h{0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
    for (std::size_t at = 0; at < text.size(); at += 64) {
        std::array<std::uint32_t, 80> w{};
        for (std::size_t i = 0; i < 64; ++i)
            w[i / 4] = w[i / 4] << 8 | std::uint8_t(text[at + i]);
        for (std::size_t i = 16; i < 80; ++i)
            w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
        auto [a, b, c, d, e] = h;
        for (std::size_t i = 0; i < 80; ++i) {
            std::uint32_t f = b ^ c ^ d, k = i < 40 ? 0x6ED9EBA1 : 0xCA62C1D6;
            if (i < 20)
                f = (b & c) | (~b & d), k = 0x5A827999;
            else if (i >= 40 && i < 60)
                f = (b & c) | (b & d) | (c & d), k = 0x8F1BBCDC;
            const std::uint32_t next = std::rotl(a, 5) + f + e + k + w[i];
            e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
        }
        h[0] += a, h[1] += b, h[2] += c, h[3] += d, h[4] += e;
    }
    std::array<std::uint8_t, 20> digest{};
    for (std::size_t i = 0; i < 20; ++i)
        digest[i] = std::uint8_t(h[i / 4] >> (24 - 8 * (i % 4)));
    return digest;
}

std::string base64(std::span<const std::uint8_t> bytes) {
    static const char* const kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t j = 0; j < 3; ++j)
            three = three << 8 | (i + j < bytes.size() ? bytes[i + j] : 0u);
        for (std::size_t j = 0; j < 4; ++j)
            text += i + j <= bytes.size() ? kLetters[three >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

enum Opcode : std::uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

void appendFrame(std::vector<std::uint8_t>& out, std::uint8_t opcode, std::string_view payload,
                 bool last = true) {
    out.push_back(std::uint8_t(opcode | (last ? 0x80 : 0)));
    if (payload.size() < 126) {
        out.push_back(std::uint8_t(payload.size()));
    } else if (payload.size() < 65536) {
        out.insert(out.end(), {126, std::uint8_t(payload.size() >> 8), std::uint8_t(payload.size())});
    } else {
        out.push_back(127);
        for (int shift = 56; shift >= 0; shift -= 8)
            out.push_back(std::uint8_t(std::uint64_t(payload.size()) >> shift));
    }
    out.insert(out.end(), payload.begin(), payload.end());
}

void sendAll(int socket, std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent <= 0) return;
        bytes = bytes.subspan(std::size_t(sent));
    }
}

void sendText(int socket, const std::string& text) {
    sendAll(socket, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

// A frame from a client. `bytes` is 0 until a whole masked frame has arrived.
struct ClientFrame {
    std::uint8_t opcode = 0;
    std::string payload;
    std::size_t bytes = 0;
    bool masked = false;
};

ClientFrame readClientFrame(std::span<const std::uint8_t> in) {
    ClientFrame frame;
    if (in.size() < 2) return frame;
    frame.opcode = in[0] & 0x0F;
    frame.masked = in[1] & 0x80;
    std::size_t length = in[1] & 0x7F, at = 2;
    if (length == 126) {
        if (in.size() < 4) return frame;
        length = std::size_t(in[2]) << 8 | in[3];
        at = 4;
    }
    if (!frame.masked || in.size() < at + 4 + length) return frame;
    for (std::size_t i = 0; i < length; ++i)
        frame.payload += char(in[at + 4 + i] ^ in[at + i % 4]);
    frame.bytes = at + 4 + length;
    return frame;
}

std::string vector(const std::array<double, 3>& v) {
    return fmt::format(R"({{"x":{:.9g},"y":{:.9g},"z":{:.9g}}})", v[0], v[1], v[2]);
}

}  // namespace

std::string webSocketAccept(const std::string& key) {
    return base64(sha1(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"));
}

std::vector<std::uint8_t> unmask(std::span<const std::uint8_t> frame) {
    const std::string payload = readClientFrame(frame).payload;
    return {payload.begin(), payload.end()};
}

Inverse3Emulator::Inverse3Emulator(const Inverse3Script& script) : script_(script) {
    force_n_.fill(std::numeric_limits<double>::quiet_NaN());
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_, generic, sizeof address) != 0 || ::listen(listener_, 8) != 0 ||
        ::getsockname(listener_, generic, &size) != 0)
        throw std::runtime_error("no loopback port to listen on");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
}

Inverse3Emulator::~Inverse3Emulator() {
    stop_.store(true);
    thread_.join();
    ::close(listener_);
}

std::int64_t Inverse3Emulator::now_ns() const {
    if (script_.time_ns) return script_.time_ns->load();
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

std::array<double, 3> Inverse3Emulator::force_n() const {
    const std::lock_guard lock(mutex_);
    return force_n_;
}

std::string Inverse3Emulator::complaint() const {
    const std::lock_guard lock(mutex_);
    return complaint_;
}

void Inverse3Emulator::complain(const std::string& what) {
    const std::lock_guard lock(mutex_);
    if (complaint_.empty()) complaint_ = what;
}

// Serves one WebSocket at a time. Also answers a GET request that arrives while the WebSocket is open.
void Inverse3Emulator::run() {
    while (!stop_.load()) {
        pollfd wait{listener_, POLLIN, 0};
        if (::poll(&wait, 1, 5) <= 0) continue;
        const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        if (client >= 0) serve(client);
    }
}

void Inverse3Emulator::serve(int client) {
    std::string head;
    char bytes[2048];
    while (head.find("\r\n\r\n") == std::string::npos) {
        const ssize_t got = ::recv(client, bytes, sizeof bytes, 0);
        if (got <= 0) break;
        head.append(bytes, std::size_t(got));
    }
    const std::string name = "Sec-WebSocket-Key: ";
    const std::size_t key = head.find(name);
    if (head.starts_with("GET /version ") && !script_.version.empty()) {
        std::string body =
            R"({"project_name":"haply-inverse-service","project_version":")" + script_.version + "\"}";
        if (script_.data_envelope) body = R"({"ok":true,"data":)" + body + "}";
        sendText(client, fmt::format("HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"
                                     "Content-Length: {}\r\n\r\n{}",
                                     body.size(), body));
    } else if (key == std::string::npos) {
        sendText(client, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
    } else {
        const std::size_t from = key + name.size();
        sendText(client,
                 "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                 "Sec-WebSocket-Accept: " +
                     webSocketAccept(head.substr(from, head.find("\r\n", from) - from)) + "\r\n\r\n");
        const int one = 1;
        ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
        connections_.fetch_add(1);
        serveClient(client);
    }
    ::close(client);
}

void Inverse3Emulator::serveClient(int client) {
    std::vector<std::uint8_t> out, in;
    appendFrame(out, kText, state(true, Inverse3Fault::none));
    sendAll(client, out);
    while (!stop_.load()) {
        pollfd waits[2] = {{client, POLLIN, 0}, {listener_, POLLIN, 0}};
        ::poll(waits, 2, 1);
        if (release_ns_ != 0 && now_ns() >= release_ns_) {
            sendAll(client, withheld_);
            withheld_.clear();
        }
        if (waits[1].revents != 0) {  // GET /version while the WebSocket is open
            const int other = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
            if (other >= 0) serve(other);
        }
        if (waits[0].revents == 0) continue;
        std::uint8_t bytes[4096];
        const ssize_t got = ::recv(client, bytes, sizeof bytes, MSG_DONTWAIT);
        if (got <= 0) return;
        in.insert(in.end(), bytes, bytes + got);
        while (true) {
            const ClientFrame frame = readClientFrame(in);
            if (in.size() >= 2 && !frame.masked) return complain("an unmasked frame");
            if (frame.bytes == 0) break;
            in.erase(in.begin(), in.begin() + std::ptrdiff_t(frame.bytes));
            if (frame.opcode == kClose) return;
            if (frame.opcode == kPong) continue;
            if (frame.opcode != kText) complain("a frame that is not text");
            command(frame.payload);
            if (answer(client)) continue;
            // For the fault `close`, wait until the client has answered the close frame and closed the
            // connection.
            ::shutdown(client, SHUT_WR);
            for (int i = 0; i < 100 && script_.fault == Inverse3Fault::close; ++i) {
                pollfd wait{client, POLLIN, 0};
                ::poll(&wait, 1, 1);
                if (::recv(client, bytes, sizeof bytes, MSG_DONTWAIT) == 0) break;
            }
            return;
        }
    }
}

// Accepts only the exact bytes that the force command has in the service's version.
void Inverse3Emulator::command(const std::string& message) {
    int major = 3, minor = 1;
    std::sscanf(script_.version.c_str(), "%d.%d", &major, &minor);
    const std::string spelling = minor >= 5 ? "vector" : "values";
    const std::string head = R"({"inverse3":[{"device_id":")" + script_.device_id +
                             R"(","commands":{"set_cursor_force":{")" + spelling + R"(":{"x":)";
    std::array<double, 3> force{};
    int used = 0;
    if (!message.starts_with(head) ||
        std::sscanf(message.c_str() + head.size(), R"(%lf,"y":%lf,"z":%lf}}}}]}%n)", &force[0], &force[1],
                    &force[2], &used) != 3 ||
        head.size() + std::size_t(used) != message.size())
        return complain(message);
    const std::lock_guard lock(mutex_);
    force_n_ = force;
}

bool Inverse3Emulator::answer(int client) {
    const std::uint64_t number = answered_.fetch_add(1);
    const bool faulty = number >= script_.from_answer && number < script_.from_answer + script_.answers;
    const Inverse3Fault fault = faulty ? script_.fault : Inverse3Fault::none;
    if (fault != Inverse3Fault::none && fault_began_ns_.load() == 0) fault_began_ns_.store(now_ns());

    const std::string text = state(false, fault);
    std::vector<std::uint8_t> out;
    if (fault == Inverse3Fault::pings)
        for (int i = 0; i < 20; ++i)
            appendFrame(out, kPing, "still there?");
    if (fault == Inverse3Fault::fragments) {
        for (std::size_t at = 0; at < text.size(); at += 100)
            appendFrame(out, at == 0 ? kText : kContinuation, std::string_view(text).substr(at, 100),
                        at + 100 >= text.size());
    } else {
        appendFrame(out, fault == Inverse3Fault::binary ? kBinary : kText, text);
    }
    if (fault == Inverse3Fault::drop) {
        if (script_.time_ns) script_.time_ns->fetch_add(kLostInverse3Answer_ns);
        return true;
    }
    if (fault == Inverse3Fault::duplicate) {
        const std::vector<std::uint8_t> again = out;
        out.insert(out.end(), again.begin(), again.end());
    }
    if (fault == Inverse3Fault::masked) out[1] |= 0x80;
    if (fault == Inverse3Fault::close) out.clear(), appendFrame(out, kClose, "\x03\xE8");
    if (fault == Inverse3Fault::stall && release_ns_ == 0)
        release_ns_ = now_ns() + 1'000'000ll * script_.stall_ms;
    if (release_ns_ > now_ns()) {
        withheld_.insert(withheld_.end(), out.begin(), out.end());
        if (script_.time_ns) script_.time_ns->fetch_add(kLostInverse3Answer_ns);
        return true;
    }
    if (fault == Inverse3Fault::cut) {
        sendAll(client, {out.data(), out.size() / 2});
        const linger reset{1, 0};
        ::setsockopt(client, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        return false;
    }
    if (fault == Inverse3Fault::flood) return flood(client, out);
    sendAll(client, out);
    return fault != Inverse3Fault::close;
}

bool Inverse3Emulator::flood(int client, const std::vector<std::uint8_t>& message) {
    std::vector<std::uint8_t> many;
    for (int i = 0; i < 100; ++i)
        many.insert(many.end(), message.begin(), message.end());
    while (!stop_.load())
        if (::send(client, many.data(), many.size(), MSG_NOSIGNAL) != ssize_t(many.size())) return false;
    return true;
}

// The messages follow the documentation's examples for versions 3.1 and 3.5.
std::string Inverse3Emulator::state(bool inventory, Inverse3Fault fault) const {
    const bool recent = !script_.version.empty() && script_.version >= "3.5";
    std::string position =
        vector({script_.cursor_m[0], script_.cursor_m[1] - out_m_.load(), script_.cursor_m[2]});
    if (fault == Inverse3Fault::notFinite) position = R"({"x":NaN,"y":0,"z":0})";
    if (fault == Inverse3Fault::huge) position = R"({"x":1e999,"y":0,"z":0})";
    if (fault == Inverse3Fault::farAway) position = R"({"x":1e6,"y":0,"z":0})";
    if (fault == Inverse3Fault::wrongType) position = R"({"x":"0","y":"0","z":"0"})";
    if (fault == Inverse3Fault::deep) position = std::string(100'000, '[');
    if (fault == Inverse3Fault::big) position = '"' + std::string(300 * 1024, 'x') + '"';
    std::string device =
        R"({"device_id":")" + (fault == Inverse3Fault::otherDevice ? "0BAD" : script_.device_id) + '"';
    if (inventory)
        device +=
            R"(,"config":{"type":"inverse3","port":"COM12","handedness":"right",)"
            R"("gravity_compensation":{"enabled":true,"scaling_factor":1.0},"torque_scaling":{"enabled":true}})";
    device += R"(,"state":{"angular_position":{"a0":-69.31704,"a1":137.62952,"a2":19.832787},)"
              R"("body_orientation":{"x":-0.01940918,"y":0.7026367,"z":0.00048828125,"w":0.7113037},)";
    if (fault != Inverse3Fault::noPosition) device += R"("cursor_position":)" + position + ',';
    device += R"("cursor_velocity":{"x":-0.011969013,"y":0.0012009288,"z":-0.043197},"mode":"idle"},)";
    device += fmt::format(
        R"("status":{{"calibrated":{},"in_use":false,"power_supply":{},"ready":true,"started":true}}}})",
        fault != Inverse3Fault::uncalibrated, fault != Inverse3Fault::noPower);

    std::string text = "{";
    if (recent && inventory) text += R"("session_id":7,)";
    const bool listed = script_.device && fault != Inverse3Fault::unplugged;
    text += R"("inverse3":[)" + (listed ? device : "") + "]";
    if (script_.grip && fault != Inverse3Fault::gripMissing) {
        const auto& q = script_.grip_wxyz;
        const double size = fault == Inverse3Fault::notAUnit ? 2.0 : 1.0;
        const std::string buttons =
            recent ? R"("buttons":{"a":true,"b":false,"c":true})" : R"("button":true,"hall":0)";
        text += fmt::format(
            R"(,"{}":[{{"device_id":"61548","state":{{{},)"
            R"("orientation":{{"x":{:.9g},"y":{:.9g},"z":{:.9g},"w":{:.9g}}}}},"status":{{"error":0}}}}])",
            recent ? "wireless_verse_grip" : "verse_grip", buttons, size * q[1], size * q[2], size * q[3],
            size * q[0]);
    }
    text += "}";
    if (fault == Inverse3Fault::brokenJson) text.resize(text.size() / 2);
    if (fault == Inverse3Fault::flipped) text[0] ^= 0x20;
    return text;
}

}  // namespace stylet::test
