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
        last_check_ns_ = now_ns;
    }
    sent_ns_[sent_ % kAnswerHistory] = now_ns;
    if (!std::exchange(waiting_, true)) awaiting_since_ns_ = now_ns;
    return encode(sent_, Force{now_ns, force_n});
}

FrameBytes Link::bye(std::string_view reason) noexcept {
    return encodeBye(++sent_, reason);
}

void Link::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns) noexcept {
    while (!bytes.empty() && fault_ == LinkFault::none) {
        const std::size_t more = std::min(bytes.size(), buffer_.size() - buffered_);
        std::memcpy(buffer_.data() + buffered_, bytes.data(), more);
        buffered_ += more;
        bytes = bytes.subspan(more);

        std::size_t at = 0;
        Frame frame;
        do {
            fail(readFrame({buffer_.data() + at, buffered_ - at}, frame));
            if (frame.bytes > 0 && fault_ == LinkFault::none) handle(frame, now_ns);
            at += frame.bytes;
        } while (frame.bytes > 0 && fault_ == LinkFault::none);
        buffered_ -= at;
        std::memmove(buffer_.data(), buffer_.data() + at, buffered_);
    }
}

void Link::handle(const Frame& frame, std::int64_t now_ns) noexcept {
    // Sequence numbers wrap.
    const auto ahead = std::int32_t(frame.sequence - last_sequence_);
    if (ahead <= 0) {
        ++counts_.repeated;
        return;
    }
    counts_.lost += std::uint64_t(ahead - 1);
    last_sequence_ = frame.sequence;

    if (frame.type == FrameType::bye) {
        const LinkFault fault = parse(frame, bye_);
        fail(fault == LinkFault::none ? LinkFault::bye : fault);
    } else if (has_capabilities_) {
        handleState(frame, now_ns);
    } else {
        fail(parse(frame, capabilities_));
        has_capabilities_ = fault_ == LinkFault::none;
    }
}

void Link::handleState(const Frame& frame, std::int64_t now_ns) noexcept {
    State state;
    if (const LinkFault fault = parse(frame, state); fault != LinkFault::none) return fail(fault);
    if (first_force_ == 0 || std::int32_t(state.answers - first_force_) < 0 ||
        std::int32_t(sent_ - state.answers) < 0)
        return fail(LinkFault::unexpected);
    const bool first = counts_.states == 0;
    if (state.sampled_ns > now_ns + kMaxClockLead_ns || (!first && state.sampled_ns < state_.sampled_ns))
        return fail(LinkFault::clock);
    // The bridge answers at once with its newest sample. A sample much older than the force means that the
    // device has stopped delivering. The send times of older forces are not stored, so an answer to one
    // counts as frozen too.
    const bool remembered = sent_ - state.answers < kAnswerHistory;
    if (!remembered || sent_ns_[state.answers % kAnswerHistory] - state.sampled_ns > kSilenceTimeout_ns)
        return fail(LinkFault::frozen);

    ++counts_.states;
    waiting_ = false;
    fresh_ = fresh_ || first || state.sampled_ns > state_.sampled_ns;
    state_ = state;
}

void Link::checkTimeout(std::int64_t now_ns) noexcept {
    if (now_ns < last_check_ns_) fail(LinkFault::clock);
    last_check_ns_ = now_ns;
    if (waiting_ && now_ns - awaiting_since_ns_ > kSilenceTimeout_ns) fail(LinkFault::silent);
}

bool Link::readState(State& state) noexcept {
    state = state_;
    return std::exchange(fresh_, false);
}

}  // namespace stylet::haptics::bridge
