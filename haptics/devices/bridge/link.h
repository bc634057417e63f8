// Stylet's side of the connection to a bridge: bytes and times in, bytes and states out. No I/O, no clock,
// no allocation, so tests can simulate years of operation. bridge.h connects it to a socket.
#pragma once

#include "haptics/devices/bridge/protocol.h"

namespace stylet::haptics::bridge {

// State of one connection. A fault is permanent: create a new Link for the next connection. Times are
// CLOCK_MONOTONIC, which both sides share.
class Link {
  public:
    // Frames to send: hello first, forces once `capabilities` have arrived, bye last.
    FrameBytes hello() noexcept;
    FrameBytes force(const Vec3& force_n, std::int64_t now_ns) noexcept;
    FrameBytes bye(std::string_view reason) noexcept;

    // Processes received bytes, in pieces of any length.
    void receive(std::span<const std::uint8_t>, std::int64_t now_ns) noexcept;
    // Detects silence, which is a fault. Call after receive(), so that our own pauses are not counted as the
    // bridge's.
    void checkTimeout(std::int64_t now_ns) noexcept;

    LinkFault fault() const noexcept { return fault_; }
    const char* reason() const noexcept { return bye_.reason.data(); }   // of LinkFault::bye
    bool hasCapabilities() const noexcept { return has_capabilities_; }  // the capabilities have arrived
    const Capabilities& capabilities() const noexcept { return capabilities_; }
    // Copies the newest state. Returns true if its sample is newer than at the last call.
    bool readState(State&) noexcept;

    struct Counts {
        std::uint64_t states = 0;
        std::uint64_t repeated = 0;  // duplicate or out-of-order frames: ignored
        std::uint64_t lost = 0;      // sequence numbers that never arrived
    };
    const Counts& counts() const noexcept { return counts_; }

  private:
    void handle(const Frame&, std::int64_t now_ns) noexcept;
    void handleState(const Frame&, std::int64_t now_ns) noexcept;
    void fail(LinkFault fault) noexcept {
        if (fault_ == LinkFault::none) fault_ = fault;
    }

    static constexpr std::uint32_t kAnswerHistory = 64;  // number of recent forces whose answers are accepted

    LinkFault fault_ = LinkFault::none;
    bool has_capabilities_ = false, fresh_ = false;
    std::uint32_t sent_ = 0, last_sequence_ = 0;  // sequence numbers; each side counts from 1
    std::array<std::int64_t, kAnswerHistory> sent_ns_{};
    std::uint32_t first_force_ = 0;
    bool waiting_ = false;
    std::int64_t awaiting_since_ns_ =
        0;  // send time of the first force after the last answer, while `waiting_`
    std::int64_t last_check_ns_ = 0;
    std::array<std::uint8_t, kMaxFrameBytes> buffer_{};
    std::size_t buffered_ = 0;
    Capabilities capabilities_;
    State state_;
    Bye bye_;
    Counts counts_;
};

}  // namespace stylet::haptics::bridge
