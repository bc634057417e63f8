#include "haptics/devices/bridge/server.h"

namespace stylet::haptics::bridge {

namespace {

void append(std::vector<std::uint8_t>& out, const FrameBytes& frame) {
    out.insert(out.end(), frame.span().begin(), frame.span().end());
}

}  // namespace

Vec3 Servo::tick(const Sample& sample, double force_peak_n) noexcept {
    Command newest;
    commands_.read(newest);
    const std::int64_t age_ns = sample.sampled_ns - newest.force.sent_ns;
    const Vec3& commanded_n = newest.force.force_n;
    const bool none = commanded_n == Vec3(0.0);
    if (!newest.live || age_ns > kSilenceTimeout_ns || age_ns < -kMaxClockLead_ns)
        tripped_ = true;
    else if (none)
        tripped_ = false;
    samples_.publish({sample, tripped_, true});
    if (tripped_ || none) return Vec3(0.0);
    const double size_n = glm::length(commanded_n);
    return size_n > force_peak_n ? commanded_n * (force_peak_n / size_n) : commanded_n;
}

bool Servo::readSample(Sample& sample, bool& watchdog) noexcept {
    Published published;
    samples_.read(published);
    sample = published.sample;
    watchdog = published.watchdog;
    return published.any;
}

bool Session::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
    buffered_.insert(buffered_.end(), bytes.begin(), bytes.end());
    std::size_t at = 0;
    while (true) {
        Frame frame;
        const LinkFault fault = readFrame(std::span(buffered_).subspan(at), frame);
        if (fault != LinkFault::none) return refuse(fault, out);
        if (frame.bytes == 0) break;
        if (!handle(frame, out)) return false;
        at += frame.bytes;
    }
    buffered_.erase(buffered_.begin(), buffered_.begin() + std::ptrdiff_t(at));
    return true;
}

bool Session::handle(const Frame& frame, std::vector<std::uint8_t>& out) {
    if (std::int32_t(frame.sequence - last_sequence_) <= 0) return true;  // duplicate
    last_sequence_ = frame.sequence;
    if (frame.type == FrameType::bye) return false;
    if (!greeted_) {
        Hello hello;
        if (const LinkFault fault = parse(frame, hello); fault != LinkFault::none) return refuse(fault, out);
        if (kVersion < hello.lowest_version || kVersion > hello.highest_version)
            return refuse(LinkFault::version, out);
        greeted_ = true;
        append(out, encode(++sent_, capabilities_));
        return true;
    }
    Force force;
    if (const LinkFault fault = parse(frame, force); fault != LinkFault::none) return refuse(fault, out);
    servo_.command(force);
    Sample sample;
    bool watchdog = true;
    if (!servo_.readSample(sample, watchdog)) return true;
    append(out, encode(++sent_, State{frame.sequence, sample.sampled_ns, sample.device_from_stylus,
                                      sample.buttons, sample.motors, sample.hand_on, watchdog}));
    return true;
}

void Session::end(std::string_view reason, std::vector<std::uint8_t>& out) {
    append(out, encodeBye(++sent_, reason));
}

bool Session::refuse(LinkFault fault, std::vector<std::uint8_t>& out) {
    end(describe(fault), out);
    return false;
}

}  // namespace stylet::haptics::bridge
