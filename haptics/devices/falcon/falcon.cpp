#include "haptics/devices/falcon/falcon.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "haptics/devices/profiles.h"

namespace stylet::haptics::falcon {

namespace {

constexpr double kCountsPerNewtonMetre = 10'000.0;
constexpr double kMaxCounts = 4095.0;

// About 0.6 s. The public driver polls a thousand times.
constexpr int kMaxProbes = 60;
constexpr int kMaxLoads = 10;
constexpr int kTransferWait_ms = 3;
constexpr std::int64_t kReply_ns = 4'000'000, kProbe_ns = 10'000'000;
// One garbled reply must not count as homing: the zero position and all forces would be wrong.
constexpr int kHomedReplies = 10;
// A garbled count may look valid. A hand is assumed to continue its motion within this tolerance. It allows
// 600 m/s^2, six times what the motors and a blow of the hand can cause. isPlausibleMotion() also allows for
// 1 ms of uncertainty in the time at which the count was read.
constexpr double kMaxDeviationPerMs = 40.0;
constexpr double kMaxExtrapolation_ms = 5.0;

}  // namespace

DeviceProfile makeProfile(const Calibration& calibration) noexcept {
    DeviceProfile profile = *findProfile("falcon");
    profile.force_calibrated = calibration.measured;
    profile.workspace_centre_m = {0.0, 0.0, 0.1225};  // centre of the usable 75 to 170 mm
    return profile;
}

std::array<std::int16_t, 3> computeMotorCounts(const Vec3& force_n, const Vec3& grip_m,
                                               const Calibration& calibration) noexcept {
    if (!isFinite(force_n)) return {};
    const double length = std::sqrt(glm::dot(force_n, force_n));
    const double most_n = findProfile("falcon")->force_peak_n;
    const Vec3 wanted = length > most_n ? force_n * (most_n / length) : force_n;
    const auto torques_n_m = computeTorques(wanted / calibration.measured_per_asked, grip_m);
    if (!torques_n_m || !isFinite(*torques_n_m)) return {};
    Vec3 counts = -kCountsPerNewtonMetre * *torques_n_m;
    const double most = std::max({std::fabs(counts.x), std::fabs(counts.y), std::fabs(counts.z)});
    if (most > kMaxCounts) counts *= kMaxCounts / most;
    return {std::int16_t(std::lround(counts.x)), std::int16_t(std::lround(counts.y)),
            std::int16_t(std::lround(counts.z))};
}

FalconDriver::FalconDriver(std::unique_ptr<FtdiBus> bus, const Clock& clock, Settings settings)
    : bus_(std::move(bus)),
      clock_(clock),
      settings_(std::move(settings)),
      profile_(makeProfile(settings_.calibration)),
      loader_(*bus_, clock) {}

FalconDriver::~FalconDriver() {
    close();
}

DeviceStage FalconDriver::open(std::string& why) {
    const DeviceStage stage = bus_->open(why);
    if (stage == DeviceStage::absent) loads_ = 0;
    if (stage != DeviceStage::opening) return stage;
    open_ = true;
    step_ = Step::probe;
    probes_ = 0;
    homed_ = reply_pending_ = jumping_ = false;
    homed_replies_ = 0;
    reader_.clear();
    const BusResult purged = bus_->control(kFtdiReset, kPurgeReceived, why);
    if (purged == BusResult::ok && bus_->control(kFtdiReset, kPurgeToSend, why) == BusResult::ok &&
        setNormalMode(*bus_, why) == BusResult::ok)
        return DeviceStage::opening;
    if (why.empty()) why = "the Falcon's FTDI chip could not be configured";
    return DeviceStage::failed;
}

DeviceStage FalconDriver::exchange(const Vec3& force_n, DeviceState& state, std::string& why) {
    switch (step_) {
        case Step::probe:
            return probe(why);
        case Step::load:
            return load(why);
        case Step::run:
            return run(force_n, state, why);
    }
    return DeviceStage::failed;
}

void FalconDriver::close() noexcept {
    if (!open_) return;
    open_ = false;
    try {
        // Several packets, because the first may complete a truncated one.
        std::string why;
        BusBytes ignored;
        for (int i = 0; i < 3 && step_ == Step::run; ++i) {
            if (bus_->write(encode({}), kTransferWait_ms, why) == BusResult::lost) break;
            bus_->read(ignored, kTransferWait_ms, why);
        }
    } catch (...) {
        // Nothing more can be done.
    }
    bus_->close();
}

// Running firmware answers an empty command. Without firmware the chip sends only its status.
DeviceStage FalconDriver::probe(std::string& why) {
    std::optional<Reply> reply;
    if (sendAndReceive({}, now() + kProbe_ns, reply, why) == BusResult::lost) return reportLost(why);
    if (reply) {
        step_ = Step::run;
        loads_ = 0;
        last_reply_ns_ = now();
        trouble_ = Trouble::none;
        return DeviceStage::needsHoming;
    }
    if (++probes_ < kMaxProbes) return DeviceStage::opening;
    if (settings_.firmware.image.empty()) {
        why =
            "the Falcon has no firmware, which is lost at power-off: pass the vendor's file with --firmware";
    } else if (loads_ >= kMaxLoads) {
        why =
            "the Falcon's firmware could not be loaded in ten tries: unplug it, check its power supply, plug "
            "it in";
    } else {
        step_ = Step::load;
        loader_.begin();
    }
    return DeviceStage::needsFirmware;
}

DeviceStage FalconDriver::load(std::string& why) {
    switch (loader_.step(settings_.firmware.image, why)) {
        case FirmwareLoader::Outcome::inProgress:
            why = "loading the Falcon's firmware";
            return DeviceStage::needsFirmware;
        case FirmwareLoader::Outcome::done:
            step_ = Step::probe;
            probes_ = 0;
            ++loads_;
            return DeviceStage::opening;
        case FirmwareLoader::Outcome::failed:
            // PolledDevice closes and reopens the device, which often helps.
            ++loads_;
            why = "the Falcon's firmware could not be loaded: " + why;
            return DeviceStage::failed;
        case FirmwareLoader::Outcome::lost:
            break;
    }
    return reportLost(why);
}

DeviceStage FalconDriver::run(const Vec3& force_n, DeviceState& state, std::string& why) {
    const std::int64_t begin_ns = now();
    if (last_reply_ns_ > begin_ns) last_reply_ns_ = begin_ns - kReplyDeadline_ns;  // the clock was set back
    Command command{.leds = homed_ ? kLedGreen : kLedRed};
    if (homed_ && begin_ns - last_reply_ns_ < kReplyDeadline_ns)
        command.motors = computeMotorCounts(force_n, grip_m_, settings_.calibration);

    std::optional<Reply> reply;
    const std::uint64_t refused = reader_.refused();
    if (sendAndReceive(command, begin_ns + kReply_ns, reply, why) == BusResult::lost) return reportLost(why);
    if (reply) {
        if (processReply(*reply, now(), state)) last_reply_ns_ = now();
    } else {
        recordTrouble(reader_.refused() != refused ? Trouble::garbled : Trouble::silent);
    }
    if (now() - last_reply_ns_ > kGiveUp_ns) return giveUp(why);
    if (homed_) return DeviceStage::ready;
    why = "pull its grip all the way out, then push it all the way in";
    return DeviceStage::needsHoming;
}

// Sends one command and waits until `until_ns` for the newest reply.
BusResult FalconDriver::sendAndReceive(const Command& command, std::int64_t until_ns,
                                       std::optional<Reply>& reply, std::string& why) {
    if (reply_pending_) {
        // Otherwise the late reply would be matched with this command, and every later reply with the command
        // after its own.
        reader_.clear();
        if (bus_->control(kFtdiReset, kPurgeReceived, why) == BusResult::lost) return BusResult::lost;
    }
    BusResult result = bus_->write(encode(command), kTransferWait_ms, why);
    // The number of turns is limited too, because the clock may be set back meanwhile.
    for (int turn = 0; turn < 20 && result == BusResult::ok && !reply; ++turn) {
        BusBytes got;
        if (bus_->read(got, kTransferWait_ms, why) == BusResult::lost) return BusResult::lost;
        reply = reader_.push(got.span());
        if (now() >= until_ns) break;
    }
    reply_pending_ = !reply;
    return result;
}

// Returns false if the reply is implausible. There is no position until all three encoders have found their
// zero.
bool FalconDriver::processReply(const Reply& reply, std::int64_t now_ns, DeviceState& state) noexcept {
    if (reply.homed != kHomedAll) {
        homed_ = false;
        homed_replies_ = 0;
        trouble_ = Trouble::none;
        return true;
    }
    const double elapsed_ms = double(now_ns - last_reply_ns_) * 1e-6;
    if (homed_replies_ > 0 && !isPlausibleMotion(reply.encoders, elapsed_ms)) {
        recordTrouble(Trouble::jumped);
        return false;
    }
    const auto grip = gripFromAngles(anglesFromCounts(reply.encoders), grip_m_);
    if (!grip) {
        recordTrouble(Trouble::impossible);
        return false;
    }
    homed_replies_ = std::min(homed_replies_ + 1, kHomedReplies);
    homed_ = homed_replies_ == kHomedReplies;
    trouble_ = Trouble::none;
    for (int i = 0; i < 3; ++i) {
        const auto leg = std::size_t(i);
        const bool steady = homed_replies_ > 1 && elapsed_ms > 0.2 && elapsed_ms < kMaxExtrapolation_ms;
        rates_[i] = steady ? (reply.encoders[leg] - counts_[leg]) / elapsed_ms : 0.0;
    }
    counts_ = reply.encoders;
    grip_m_ = *grip;
    if (!homed_) return true;
    state.device_from_stylus = {Quat{1.0, 0.0, 0.0, 0.0}, *grip};
    state.buttons = reply.buttons;
    state.fresh = 1;
    return true;
}

// True if a hand can have moved there. A jump does not become valid as time passes. Only after silence is a
// larger motion allowed, because the hand then had that long to move.
bool FalconDriver::isPlausibleMotion(const Counts& counts, double elapsed_ms) noexcept {
    if (!jumping_) silence_ms_ = std::max(1.0, elapsed_ms);
    jumping_ = false;
    for (int i = 0; i < 3; ++i) {
        const auto leg = std::size_t(i);
        const double expected = counts_[leg] + rates_[i] * std::min(elapsed_ms, kMaxExtrapolation_ms);
        const double doubt = kMaxDeviationPerMs * silence_ms_ + std::fabs(rates_[i]);
        jumping_ = jumping_ || std::fabs(counts[leg] - expected) > doubt;
    }
    return !jumping_;
}

// Keeps the first problem since the last valid reply. Silence is replaced by a later problem, because silence
// can be its consequence.
void FalconDriver::recordTrouble(Trouble trouble) noexcept {
    if (trouble_ == Trouble::none || trouble_ == Trouble::silent) trouble_ = trouble;
}

DeviceStage FalconDriver::reportLost(std::string& why) {
    loads_ = 0;
    if (why.empty()) why = "the connection to the Falcon was lost: plug it in again";
    return DeviceStage::failed;
}

DeviceStage FalconDriver::giveUp(std::string& why) const {
    static constexpr std::array<std::string_view, 5> kTexts{
        // in the order of Trouble
        "the Falcon stopped answering", "the Falcon stopped answering", "the Falcon's replies are garbled",
        "the Falcon's encoders jumped faster than any hand",
        "the Falcon's encoders report an impossible pose"};
    why = enumName(kTexts, trouble_);
    return DeviceStage::failed;
}

}  // namespace stylet::haptics::falcon
