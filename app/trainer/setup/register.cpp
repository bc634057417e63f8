#include "app/trainer/setup/register.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <ctime>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "app/installation.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/setup/register_card.h"
#include "app/trainer/setup/register_view.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using xr::registration::Cube;
using xr::registration::Fit;
using xr::registration::StoredRegistration;
using xr::registration::TimedPose;
using xr::registration::Wizard;
using xr::registration::WizardInput;
using xr::registration::WizardSettings;
using xr::registration::WizardStage;
using xr::registration::WizardText;

namespace {

constexpr std::int64_t kRegisterSample_ns = 4'000'000, kLinger_ns = 1'500'000'000;
constexpr double kCubeOfReach = 0.55;  // a cube's corner is sqrt(3) half edges from its centre
constexpr double kSmallestHalf_m = 0.015, kHalf_m = 0.04;
constexpr std::uint32_t kPress = 1u << 0, kBack = 1u << 1;  // buttons of the device itself

// The opened device: a real one, or a recorded trace.
struct RegisterHand {
    std::unique_ptr<LiveDevice> live;
    haptics::Trace trace;
    std::optional<haptics::ReplayDevice> replay;
    haptics::HapticDevice& device() {
        return live ? live->bare() : static_cast<haptics::HapticDevice&>(*replay);
    }
};

// Samples device and controller at the same times. Uses its own thread, because frames take too long.
class Sampler {
  public:
    struct Samples {
        std::vector<TimedPose> device, tracked;
        std::uint32_t pressed = 0;  // buttons of the device that were newly pressed
        double now_s = 0.0;
    };
    Sampler(haptics::HapticDevice& device, const RegisterView& view, const haptics::Clock& clock)
        : device_(device), view_(view), clock_(clock), begin_ns_(clock.now_ns(clock.context)) {
        thread_ = std::thread([this] { run(); });
    }
    ~Sampler() {
        stop_.store(true);
        thread_.join();
    }
    Sampler(const Sampler&) = delete;
    Sampler& operator=(const Sampler&) = delete;

    // Returns the samples since the last call. With a `bare` hand, drops the tracked poses, because they are
    // too inaccurate.
    Samples popSamples(bool bare) {
        const std::lock_guard lock(mutex_);
        Samples taken = std::exchange(new_, {});
        if (bare) taken.tracked.clear();
        taken.now_s = seconds(clock_.now_ns(clock_.context));
        return taken;
    }

  private:
    double seconds(std::int64_t t_ns) const { return 1e-9 * double(t_ns - begin_ns_); }
    void run() {
        std::int64_t due_ns = begin_ns_;
        std::uint32_t buttons = 0;
        while (!stop_.load()) {
            const std::int64_t now_ns = clock_.now_ns(clock_.context);
            const haptics::DeviceState state = device_.read(now_ns);
            const auto grip = view_.gripAt(now_ns);
            {
                const std::lock_guard lock(mutex_);
                if ((state.flags & haptics::kDeviceReady) != 0) {
                    new_.device.push_back({seconds(now_ns), state.device_from_stylus});
                    new_.pressed |= state.buttons & ~buttons;
                    buttons = state.buttons;
                }
                if (grip) new_.tracked.push_back({seconds(now_ns), *grip});
            }
            // After a delay the next sample is due immediately. Missed samples are not repeated.
            due_ns = std::max(due_ns + kRegisterSample_ns, now_ns);
            clock_.sleepUntil_ns(clock_.context, due_ns);
        }
    }

    haptics::HapticDevice& device_;
    const RegisterView& view_;
    const haptics::Clock clock_;
    const std::int64_t begin_ns_;
    std::mutex mutex_;
    Samples new_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

// Prints changes of the card's text on the console, for a user who does not wear the headset.
class Console {
  public:
    void print(const WizardText& text) {
        if (text.title != title_ || text.what != what_) printMessage(text.title + ": " + text.what);
        if (text.next_action != awaited_ && !text.next_action.empty()) printMessage("  " + text.next_action);
        if (text.note != note_ && !text.note.empty()) printMessage("  " + text.note);
        title_ = text.title, what_ = text.what, awaited_ = text.next_action, note_ = text.note;
    }

  private:
    std::string title_, what_, awaited_, note_;
};

// Returns true if the button was pressed since the last call.
struct Edge {
    bool before = true;  // a button that is down at the start does not count as pressed
    bool operator()(bool now) { return now && !std::exchange(before, now) ? true : (before = now, false); }
};

// Typed commands: Enter continues, and "back" undoes the last step.
struct TypedInput {
    std::string rest;
    bool open = true;
    void read(bool& press, bool& back) {
        if (open) open = readTyped(rest);
        while (const std::optional<std::string> line = popLine(rest)) {
            press |= line->empty();
            back |= *line == "back";
            if (!line->empty() && *line != "back")
                printMessage(
                    "  Press Enter to continue, type \"back\" and Enter to undo the last one, press Ctrl-C "
                    "to end");
        }
    }
};

void check(const RegisterOptions& o) {
    checkDeviceName(o.device, {kReplayDevice});
    checkTraceOption(o.device, o.trace);
    if (!o.grip_from_tip_mm.empty() && o.grip_from_tip_mm.size() != 3)
        throw UsageError("--tip-mm: must be three numbers: x y z in the controller's grip frame");
    if (o.device != kReplayDevice) haptics::makeDriver(o.device, o.device_options, monotonicClock());
}

RegisterHand registerHand(const RegisterOptions& options, const haptics::Clock& clock) {
    if (options.device == kReplayDevice) return {{}, haptics::loadTrace(options.trace), {}};
    return {openReadyDevice(options.device, options.device_options, clock), {}, {}};
}

std::string utcTimestamp() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text.data();
}

// Estimates the needle pose. Uses the controller until there is a registration result, and the device after
// that.
std::optional<Pose> estimateNeedle(const Wizard& wizard, const Sampler::Samples& taken) {
    if (wizard.fit()) {
        if (taken.device.empty()) return std::nullopt;
        const Pose& stylus = taken.device.back().pose;
        return Pose{wizard.fit()->stage_from_device.rotation * stylus.rotation,
                    wizard.fit()->inStage(stylus)};
    }
    const auto tip_m = wizard.gripFromTip_m();
    if (!tip_m || taken.tracked.empty()) return std::nullopt;
    Pose needle = taken.tracked.back().pose;
    needle.position_m = needle * *tip_m;
    return needle;
}

struct RegistrationRun {
    const RegisterOptions& options;
    haptics::HapticDevice& device;
    RegisterView& view;
    const haptics::Clock& clock;
    const std::function<void()>& each_frame;
    RegistrationKey key;
    WizardSettings settings;

    // Returns true if a registration was stored or an earlier one is still valid.
    bool run();
    std::filesystem::path file() const {
        return options.out.empty() ? registrationFile(registrationsFolder(), key) : options.out;
    }
    bool save(const Fit&) const;
    void showResult(RegisterCard&, const WizardText&) const;
};

bool RegistrationRun::save(const Fit& fit) const {
    const Registration registration = makeRegistration(fit, settings.cube, key, utcTimestamp());
    saveRegistration(registration, file());
    printResult(
        "Saved: {}\n{} points, {} left out; FRE {:.2f} mm; expected error {:.2f} mm, {:.2f} at worst; scale "
        "{:.4f}, clock offset {:.1f} ms\n",
        file().string(), registration.points, registration.rejected, 1e3 * registration.fre_m,
        1e3 * registration.tre_mean_m, 1e3 * registration.tre_worst_m, registration.scale,
        1e3 * registration.latency_s);
    return true;
}

void RegistrationRun::showResult(RegisterCard& card, const WizardText& text) const {
    card.show(text, {});
    const std::int64_t until_ns = clock.now_ns(clock.context) + kLinger_ns;
    while (clock.now_ns(clock.context) < until_ns && !interrupted())
        if (view.frame({card.rgba().data(), card.revision()}).over) return;
}

bool RegistrationRun::run() {
    Wizard wizard(settings);
    RegisterCard card;
    Console console;
    TypedInput typing;
    Edge select, menu;
    Sampler sampler(device, view, clock);
    RegisterInput answer;
    std::optional<Pose> needle;
    while (!interrupted()) {
        if (each_frame) each_frame();
        const Sampler::Samples taken = sampler.popSamples(answer.bare);
        WizardInput input{taken.now_s, taken.device, taken.tracked};
        input.press = select(answer.select) || (taken.pressed & kPress) != 0;
        input.back = menu(answer.menu) || (taken.pressed & kBack) != 0;
        typing.read(input.press, input.back);
        if (answer.space_moved) {
            printMessage("the runtime moved the room: starting from the beginning");
            key.generation = view.generation(), key.space = view.space();
            settings.earlier.reset();
            wizard = Wizard(settings);
        }
        wizard.step(input);
        WizardText text = wizard.text();
        if (answer.bare)
            text.note = "A bare hand is not accurate enough: use a controller.", text.is_warning = true;
        console.print(text);
        card.show(text, wizard.sketch());
        if (wizard.stage() == WizardStage::accepted) {
            const bool done = wizard.fit() ? save(*wizard.fit()) : true;
            showResult(card, text);
            return done;
        }
        if (const auto now = estimateNeedle(wizard, taken)) needle = now;
        answer = view.frame({card.rgba().data(), card.revision(), needle});
        if (answer.over) {
            printMessage("the runtime ended the session: nothing was saved");
            return false;
        }
    }
    printMessage("cancelled: nothing was saved");
    return false;
}

}  // namespace

std::filesystem::path registrationsFolder() {
    return dataFolder() / "registrations";
}

RegistrationKey makeRegistrationKey(const std::string& kind, const haptics::DeviceProfile& profile,
                                    const std::string& space, const std::string& generation) {
    return {kind, profile.name, space, generation};
}

Cube workingCube(const haptics::DeviceProfile& profile, const Vec3& grip_m) {
    if (std::isnan(profile.workspace_radius_m)) return {grip_m, kHalf_m};
    return {profile.workspace_centre_m,
            std::clamp(kCubeOfReach * profile.workspace_radius_m, kSmallestHalf_m, kHalf_m)};
}

Registration makeRegistration(const Fit& fit, const Cube& cube, const RegistrationKey& key,
                              const std::string& date) {
    Registration r;
    r.key = key;
    r.stage_from_device = fit.stage_from_device;
    r.scale = fit.scale;
    r.stylus_from_tip_m = fit.stylus_from_tip_m;
    r.grip_from_tip_m = fit.grip_from_tip_m;
    r.latency_s = fit.latency_s;
    r.fre_m = fit.fre_m;
    r.tre_mean_m = fit.tre.mean_m, r.tre_worst_m = fit.tre.worst_m;
    r.centre_m = cube.centre_m;
    r.points = fit.inliers, r.rejected = fit.rejected;
    r.date = date;
    return r;
}

StoredRegistration toStored(const Registration& r) {
    StoredRegistration stored;
    stored.stage_from_device = r.stage_from_device;
    stored.scale = r.scale;
    stored.stylus_from_tip_m = r.stylus_from_tip_m;
    stored.grip_from_tip_m = r.grip_from_tip_m;
    stored.noise_m = std::max(stored.noise_m, r.fre_m / std::sqrt(3.0));
    stored.tre_worst_m = r.tre_worst_m;
    return stored;
}

int registerDevice(const RegisterOptions& options) {
    check(options);
    catchInterrupts();
    const haptics::Clock clock = monotonicClock();
    RegisterHand hand = registerHand(options, clock);
    std::string why_not;
    auto view = openRegisterView(
        {assetsFolder(), cacheFolder() / "pipelines.bin", options.hand == "left" ? 0 : 1, options.validation},
        why_not);
    if (!view) throw EnvironmentError("registering a device needs a headset: " + why_not);
    if (!hand.live) hand.replay.emplace(hand.trace, clock.now_ns(clock.context));

    const bool done = registerWith(options, hand.device(), *view, clock, [&hand] {
        if (hand.live) hand.live->reportStateChanges();
    });
    if (hand.live) hand.live->stop();
    return done ? 0 : 1;
}

bool registerWith(const RegisterOptions& options, haptics::HapticDevice& device, RegisterView& view,
                  const haptics::Clock& clock, const std::function<void()>& each_frame) {
    // Some runtimes report the generation of their space only once the session runs.
    for (RegisterInput first; !first.seen && !interrupted();)
        if (first = view.frame({}); first.over)
            throw EnvironmentError("the OpenXR runtime ended the session before the registration began");
    const haptics::DeviceProfile& profile = device.profile();
    RegistrationRun registering{
        options, device,     view,
        clock,   each_frame, makeRegistrationKey(options.device, profile, view.space(), view.generation()),
        {}};
    WizardSettings& settings = registering.settings;
    settings.points = options.points;
    settings.in_motion = options.in_motion;
    settings.touches = options.touches;
    settings.senses_rotation = profile.senses_rotation;
    settings.cube =
        workingCube(profile, device.read(clock.now_ns(clock.context)).device_from_stylus.position_m);
    if (!options.grip_from_tip_mm.empty())
        settings.grip_from_tip_m = 1e-3 * Vec3(options.grip_from_tip_mm[0], options.grip_from_tip_mm[1],
                                               options.grip_from_tip_mm[2]);
    if (!options.redo && std::filesystem::exists(registering.file())) {
        try {
            const Registration earlier = loadRegistration(registering.file());
            if (earlier.key == registering.key) settings.earlier = toStored(earlier);
        } catch (const DataError& e) {
            printMessage(std::string(e.what()) + ": it will be replaced");
        }
    }
    return registering.run();
}

}  // namespace stylet::trainer
