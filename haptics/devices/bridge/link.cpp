#include "haptics/devices/bridge/link.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace stylet::haptics::bridge {

FrameBytes Link::hello() noexcept {
    return encode(++sent_, Hello{});
}

FrameBytes Link::force(const Vec3& force_n, std::int64_t now_ns) noexcept {
    ++sent_;
    if (first_force_ == 0) {
        first_force_ = sent_;
        watched_ns_ = now_ns;
    }
    sent_ns_[sent_ % kRemembered] = now_ns;
    if (!std::exchange(waiting_, true)) asked_ns_ = now_ns;
    return encode(sent_, Force{now_ns, force_n});
}

FrameBytes Link::bye(const char* reason) noexcept {
    Bye bye;
    putText(bye.reason, reason);
    return encode(++sent_, bye);
}

void Link::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns) noexcept {
    while (!bytes.empty() && fault_ == LinkFault::none) {
        const std::size_t more = std::min(bytes.size(), buffer_.size() - held_);
        std::memcpy(buffer_.data() + held_, bytes.data(), more);
        held_ += more;
        bytes = bytes.subspan(more);

        std::size_t at = 0;
        Frame frame;
        do {
            fail(readFrame({buffer_.data() + at, held_ - at}, frame));
            if (frame.bytes > 0 && fault_ == LinkFault::none) handle(frame, now_ns);
            at += frame.bytes;
        } while (frame.bytes > 0 && fault_ == LinkFault::none);
        held_ -= at;
        std::memmove(buffer_.data(), buffer_.data() + at, held_);
    }
}

void Link::handle(const Frame& frame, std::int64_t now_ns) noexcept {
    // Sequence numbers wrap.
    const auto ahead = std::int32_t(frame.sequence - seen_);
    if (ahead <= 0) {
        ++counts_.repeated;
        return;
    }
    counts_.lost += std::uint64_t(ahead - 1);
    seen_ = frame.sequence;

    if (frame.type == FrameType::bye) {
        const LinkFault fault = parse(frame, bye_);
        fail(fault == LinkFault::none ? LinkFault::bye : fault);
    } else if (introduced_) {
        handleState(frame, now_ns);
    } else {
        fail(parse(frame, capabilities_));
        introduced_ = fault_ == LinkFault::none;
    }
}

void Link::handleState(const Frame& frame, std::int64_t now_ns) noexcept {
    State state;
    if (const LinkFault fault = parse(frame, state); fault != LinkFault::none) return fail(fault);
    if (first_force_ == 0 || std::int32_t(state.answers - first_force_) < 0 ||
        std::int32_t(sent_ - state.answers) < 0)
        return fail(LinkFault::unasked);
    const bool first = counts_.states == 0;
    if (state.sampled_ns > now_ns + kAhead_ns || (!first && state.sampled_ns < state_.sampled_ns))
        return fail(LinkFault::clock);
    // The bridge answers at once with its newest sample. A sample much older than the force means that the
    // device has stopped delivering. An answer to a force no longer remembered is too late to tell.
    const bool remembered = sent_ - state.answers < kRemembered;
    if (!remembered || sent_ns_[state.answers % kRemembered] - state.sampled_ns > kSilent_ns)
        return fail(LinkFault::frozen);

    ++counts_.states;
    waiting_ = false;
    fresh_ = fresh_ || first || state.sampled_ns > state_.sampled_ns;
    state_ = state;
}

void Link::watch(std::int64_t now_ns) noexcept {
    if (now_ns < watched_ns_) fail(LinkFault::clock);
    watched_ns_ = now_ns;
    if (waiting_ && now_ns - asked_ns_ > kSilent_ns) fail(LinkFault::silent);
}

bool Link::take(State& state) noexcept {
    state = state_;
    return std::exchange(fresh_, false);
}

}  // namespace stylet::haptics::bridge
