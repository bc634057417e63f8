#include "haptics/devices/bridge/server.h"

namespace stylet::haptics::bridge {

Vec3 Servo::tick(const Sample& sample, double force_peak_n) noexcept {
    Command newest;
    commands_.read(newest);
    const std::int64_t age_ns = sample.sampled_ns - newest.force.sent_ns;
    const Vec3& asked_n = newest.force.force_n;
    const bool none = asked_n.x == 0.0 && asked_n.y == 0.0 && asked_n.z == 0.0;
    if (!newest.live || age_ns > kSilent_ns || age_ns < -kAhead_ns)
        tripped_ = true;
    else if (none)
        tripped_ = false;
    samples_.publish({sample, tripped_, true});
    if (tripped_ || none) return Vec3(0.0);
    const double size_n = glm::length(asked_n);
    return size_n > force_peak_n ? asked_n * (force_peak_n / size_n) : asked_n;
}

bool Servo::newest(Sample& sample, bool& watchdog) noexcept {
    Published published;
    samples_.read(published);
    sample = published.sample;
    watchdog = published.watchdog;
    return published.any;
}

bool Session::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    std::size_t at = 0;
    while (true) {
        Frame frame;
        const LinkFault fault = readFrame(std::span(held_).subspan(at), frame);
        if (fault != LinkFault::none) return refuse(fault, out);
        if (frame.bytes == 0) break;
        if (!handle(frame, out)) return false;
        at += frame.bytes;
    }
    held_.erase(held_.begin(), held_.begin() + std::ptrdiff_t(at));
    return true;
}

bool Session::handle(const Frame& frame, std::vector<std::uint8_t>& out) {
    const auto append = [&out](const FrameBytes& bytes) {
        out.insert(out.end(), bytes.span().begin(), bytes.span().end());
    };
    if (std::int32_t(frame.sequence - seen_) <= 0) return true;  // duplicate
    seen_ = frame.sequence;
    if (frame.type == FrameType::bye) return false;
    if (!greeted_) {
        Hello hello;
        if (const LinkFault fault = parse(frame, hello); fault != LinkFault::none) return refuse(fault, out);
        if (kVersion < hello.lowest_version || kVersion > hello.highest_version)
            return refuse(LinkFault::version, out);
        greeted_ = true;
        append(encode(++sent_, capabilities_));
        return true;
    }
    Force force;
    if (const LinkFault fault = parse(frame, force); fault != LinkFault::none) return refuse(fault, out);
    servo_.command(force);
    Sample sample;
    bool watchdog = true;
    if (!servo_.newest(sample, watchdog)) return true;
    append(encode(++sent_, State{frame.sequence, sample.sampled_ns, sample.device_from_stylus, sample.buttons,
                                 sample.motors, sample.hand_on, watchdog}));
    return true;
}

void Session::end(const char* reason, std::vector<std::uint8_t>& out) {
    Bye bye;
    putText(bye.reason, reason);
    const FrameBytes bytes = encode(++sent_, bye);
    out.insert(out.end(), bytes.span().begin(), bytes.span().end());
}

bool Session::refuse(LinkFault fault, std::vector<std::uint8_t>& out) {
    end(describe(fault), out);
    return false;
}

}  // namespace stylet::haptics::bridge
