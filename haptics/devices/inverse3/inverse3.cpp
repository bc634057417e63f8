#include "haptics/devices/inverse3/inverse3.h"

#include <fmt/core.h>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>

#include "haptics/devices/inverse3/inverse3_messages.h"

namespace stylet::haptics {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;

namespace {

constexpr std::size_t kMaxVersionBytes = 16 * 1024;
constexpr std::int64_t kCloseTimeout_ns = 10'000'000;
// Limit per call. A service answers each command once; 1 MiB is more than a thousand answers.
constexpr std::size_t kMaxBytesPerCall = 1024 * 1024;
constexpr int kMaxHandlers = 1000;

// Runs pending operations until `done`. Returns false if the time is up first.
template <typename Done>
bool runUntil(asio::io_context& io, const Clock& clock, std::int64_t deadline_ns, const Done& done) {
    while (!done()) {
        const std::int64_t left_ns = deadline_ns - clock.now();
        if (left_ns <= 0) return false;
        io.restart();
        io.run_one_for(std::chrono::nanoseconds(left_ns));
    }
    return true;
}

// Runs one operation with a deadline. Returns its error, or timed_out if it has not completed by then.
template <typename Start>
beast::error_code await(asio::io_context& io, const Clock& clock, std::int64_t deadline_ns,
                        const Start& start) {
    const auto result = std::make_shared<std::optional<beast::error_code>>();
    start([result](beast::error_code error, auto&&...) { *result = error; });
    if (!runUntil(io, clock, deadline_ns, [&] { return result->has_value(); })) return asio::error::timed_out;
    return **result;
}

// Runs the handlers that are ready, up to a limit, because a flood of pings would never end.
void runReadyHandlers(asio::io_context& io) {
    io.restart();
    for (int i = 0; i < kMaxHandlers && io.poll_one() > 0;)
        ++i;
}

// Returns the body of GET `target`, empty on failure.
std::string get(asio::io_context& io, const Clock& clock, const tcp::endpoint& endpoint, const char* target,
                std::int64_t deadline_ns) {
    beast::tcp_stream stream(io);
    beast::flat_buffer buffer(kMaxVersionBytes);
    http::request<http::empty_body> request(http::verb::get, target, 11);
    request.set(http::field::host, "localhost");
    request.keep_alive(false);
    http::response_parser<http::string_body> parser;
    parser.body_limit(kMaxVersionBytes);
    parser.header_limit(4096);
    if (await(io, clock, deadline_ns, [&](auto done) { stream.async_connect(endpoint, done); }) ||
        await(io, clock, deadline_ns, [&](auto done) { http::async_write(stream, request, done); }) ||
        await(io, clock, deadline_ns, [&](auto done) { http::async_read(stream, buffer, parser, done); }) ||
        parser.get().result() != http::status::ok) {
        // Pending operations refer to objects that are about to be destroyed.
        beast::error_code ignored;
        stream.socket().close(ignored);
        runReadyHandlers(io);
        return {};
    }
    return parser.get().body();
}

}  // namespace

// One read and at most one write are pending at any time.
struct Inverse3Driver::Connection {
    explicit Connection(const Clock& time) : clock(time) {}

    Clock clock;
    asio::io_context io{1};
    websocket::stream<beast::tcp_stream> socket{io};
    beast::flat_buffer incoming{inverse3::kMaxMessageBytes};
    std::string outgoing;
    bool writing = false, arrived = false;
    beast::error_code error;
    bool waiting = false;
    std::int64_t awaiting_since_ns =
        0;  // send time of the first command after the last answer, while `waiting`
    inverse3::Spelling spelling = inverse3::Spelling::vector;
    inverse3::Update newest;

    void read() {
        arrived = false;
        incoming.clear();
        socket.async_read(incoming, [this](beast::error_code failed, std::size_t) {
            arrived = !failed;
            if (failed) error = failed;
        });
    }
    // Skipped while the last write is still pending: only the newest force matters.
    void send(const std::string& device_id, const Vec3& force_n) {
        const std::int64_t now_ns = clock.now();
        if (!std::exchange(waiting, true)) awaiting_since_ns = now_ns;
        if (writing) return;
        inverse3::writeForce(outgoing, device_id, force_n, spelling);
        writing = true;
        socket.async_write(asio::buffer(outgoing), [this](beast::error_code failed, std::size_t) {
            writing = false;
            // A failing read cancels the write; the read's own error is the cause.
            if (failed && failed != asio::error::operation_aborted && !error) error = failed;
        });
    }
    bool waitForMessage(std::int64_t deadline_ns) {
        runReadyHandlers(io);
        runUntil(io, clock, deadline_ns, [this] { return arrived || error; });
        return arrived && !error;
    }
    // Processes all messages that have arrived; the newest counts. Returns false if one was invalid.
    bool parsePending(bool& any, std::string& why) {
        std::size_t bytes = 0;
        for (; waitForMessage(0); any = true) {
            bytes += incoming.size();
            if (bytes > kMaxBytesPerCall) {
                why = "too many messages at once";
                return false;
            }
            if (!parseMessage(why)) return false;
        }
        return true;
    }
    bool parseMessage(std::string& why) {
        const auto bytes = incoming.cdata();
        const std::string_view text(static_cast<const char*>(bytes.data()), bytes.size());
        auto update = socket.got_text() ? inverse3::parseUpdate(text, why) : std::nullopt;
        if (!socket.got_text()) why = "not text";
        if (!update) return false;
        newest = std::move(*update);
        waiting = false;
        read();
        return true;
    }
    std::string lost() const {
        if (error == websocket::error::closed) return "the service closed the connection";
        if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
            return "a message of more than 256 KiB";
        return "the service is gone: " + error.message();
    }
};

Inverse3Driver::Inverse3Driver(const Clock& clock, const Inverse3Settings& settings)
    : clock_(clock), settings_(settings) {
    profile_.name = "inverse3";
    profile_.force_peak_n = settings.force_peak_n.value_or(kWeakestForce_n);
    profile_.stiffness_n_per_m = kWeakestStiffness_n_per_m;
    profile_.source = settings.force_peak_n
                          ? "force as set by the user; stiffness: the weakest device's; Haply publishes none"
                          : "the weakest device's limits: Haply publishes none, the user has set none";
    profile_.senses_rotation = false;
}

Inverse3Driver::~Inverse3Driver() {
    close();
}

DeviceStage Inverse3Driver::open(std::string& why) {
    close();
    const std::int64_t deadline_ns = clock_.now() + settings_.greeting_ns;
    const bool given = !settings_.address.empty();
    DeviceStage stage = connect(given ? settings_.address : "127.0.0.1", deadline_ns, why);
    if (stage == DeviceStage::absent && !given) stage = connect("::1", deadline_ns, why);
    return stage == DeviceStage::opening ? readInventory(deadline_ns, why) : stage;
}

DeviceStage Inverse3Driver::connect(const std::string& address, std::int64_t deadline_ns, std::string& why) {
    beast::error_code error;
    const auto host = asio::ip::make_address(address, error);
    // The peer can move a trainee's hand, so remote machines are refused.
    if (error || !host.is_loopback())
        return fail(why, address + " is not an address of this machine: use 127.0.0.1 or ::1");
    const tcp::endpoint endpoint(host, settings_.port);

    connection_ = std::make_unique<Connection>(clock_);
    Connection& c = *connection_;
    auto& stream = beast::get_lowest_layer(c.socket);
    error = await(c.io, clock_, deadline_ns, [&](auto done) { stream.async_connect(endpoint, done); });
    if (error) {
        fail(why,
             fmt::format("Haply's service does not answer on port {}: {}", settings_.port, error.message()));
        return DeviceStage::absent;
    }
    stream.socket().set_option(tcp::no_delay(true), error);
    c.socket.read_message_max(inverse3::kMaxMessageBytes);
    error = await(c.io, clock_, deadline_ns,
                  [&](auto done) { c.socket.async_handshake("localhost", "/", done); });
    if (error) return fail(why, "the service does not speak WebSocket: " + error.message());
    c.socket.text(true);
    c.read();
    return DeviceStage::opening;
}

DeviceStage Inverse3Driver::readInventory(std::int64_t deadline_ns, std::string& why) {
    Connection& c = *connection_;
    if (!c.waitForMessage(deadline_ns))
        return fail(why, c.error ? c.lost() : "the service sends no inventory");
    if (std::string what; !c.parseMessage(what)) return fail(why, "the service's inventory: " + what);
    if (!c.newest.present) {
        fail(why, "Haply's service runs, but no Inverse3 is plugged in");
        return DeviceStage::absent;
    }
    if (known_ && c.newest.device_id != device_id_)
        return fail(why, "another Inverse3 answers: " + c.newest.device_id);
    std::optional<inverse3::Spelling> spelling = settings_.spelling;
    if (!spelling) {
        const auto endpoint = beast::get_lowest_layer(c.socket).socket().remote_endpoint();
        spelling = inverse3::parseSpelling(get(c.io, clock_, endpoint, "/version", deadline_ns));
    }
    c.spelling =
        spelling.value_or(c.newest.has_session ? inverse3::Spelling::vector : inverse3::Spelling::values);
    if (!known_) {
        device_id_ = c.newest.device_id;
        has_grip_ = profile_.senses_rotation = c.newest.grip_present;
        known_ = true;
    }
    return DeviceStage::opening;
}

DeviceStage Inverse3Driver::exchange(const Vec3& force_n, DeviceState& state, std::string& why) {
    Connection& c = *connection_;
    const std::int64_t began_ns = clock_.now();
    // Read late answers first, so that none is mistaken for the answer to this force.
    bool any = false;
    std::string what;
    bool good = c.parsePending(any, what);
    if (good) {
        c.send(device_id_, force_n);
        c.waitForMessage(std::min(began_ns + settings_.answer_ns, c.awaiting_since_ns + settings_.silent_ns));
        good = c.parsePending(any, what);
    }
    if (!good) return fail(why, "a message of the service: " + what);
    if (c.error) return fail(why, c.lost());
    state.fresh = any;
    if (c.waiting && clock_.now() - c.awaiting_since_ns >= settings_.silent_ns)
        return fail(why, fmt::format("nothing from the service for {} ms", settings_.silent_ns / 1'000'000));
    if (!c.newest.present || c.newest.device_id != device_id_) return fail(why, "the Inverse3 was unplugged");
    return evaluate(c.newest, state, why);
}

// Evaluates the newest message.
DeviceStage Inverse3Driver::evaluate(const inverse3::Update& update, DeviceState& state,
                                     std::string& why) const {
    state.device_from_stylus = inverse3::stylusPose(update);
    state.buttons = update.buttons;
    state.flags = kDeviceHandOn;
    if (!update.calibrated) {
        why = "calibrate the Inverse3: hold its grip in the holder until the light is steady";
        return DeviceStage::needsHoming;
    }
    why = !update.powered                     ? "the Inverse3 has no power supply"
          : !update.ready                     ? "the Inverse3 is not ready"
          : has_grip_ && !update.grip_present ? "the VerseGrip is gone"
                                              : "";
    if (!why.empty()) return DeviceStage::opening;
    state.flags |= kDeviceReady;
    return DeviceStage::ready;
}

DeviceStage Inverse3Driver::fail(std::string& why, const std::string& reason) {
    why = reason;
    close();
    return DeviceStage::failed;
}

void Inverse3Driver::close() noexcept {
    if (!connection_) return;
    try {
        Connection& c = *connection_;
        const std::int64_t deadline_ns = clock_.now() + kCloseTimeout_ns;
        if (c.socket.is_open() && !c.error && !device_id_.empty()) {
            const auto written = [&] { return !c.writing || c.error; };
            if (runUntil(c.io, clock_, deadline_ns, written) && !c.error) {
                c.send(device_id_, Vec3(0.0));
                runUntil(c.io, clock_, deadline_ns, written);
            }
            beast::error_code ignored;
            beast::get_lowest_layer(c.socket).socket().shutdown(tcp::socket::shutdown_send, ignored);
        }
    } catch (...) {
        // Out of memory while closing. It is enough that the service sees the socket close.
    }
    connection_.reset();
}

}  // namespace stylet::haptics
