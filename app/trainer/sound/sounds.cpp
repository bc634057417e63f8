#include "app/trainer/sound/sounds.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <future>
#include <thread>

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr auto kEvery = std::chrono::milliseconds(20);  // update interval of loops and of the listener's pose
constexpr auto kPatience = std::chrono::seconds(1);

double since_s(SteadyClock::time_point begin) {
    return std::chrono::duration<double>(SteadyClock::now() - begin).count();
}

}  // namespace

// Shared by both threads. The sound thread may hang in the device forever, so this data may outlive Sounds.
struct Sounds::Shared {
    mutable std::mutex mutex;
    std::condition_variable wake;
    SoundFrame submitted;
    bool ended = false, gone = false;  // the attempt has ended; the device is lost
    std::optional<SteadyClock::time_point> since;
    SoundTotals totals;
    double late_sum_s = 0.0;
    std::promise<void> left;

    void run(const Pose& stage_from_operator, const std::shared_ptr<const ListenerPose>& listener_pose,
             const Opened& open, const Say& say);
    bool waitForNext(SoundFrame&, std::optional<SteadyClock::time_point>&);
    void played(const SoundFrame&, const std::optional<SteadyClock::time_point>& since);
    void silent();
};

// Waits for the next sounds. Returns false at the end.
bool Sounds::Shared::waitForNext(SoundFrame& next, std::optional<SteadyClock::time_point>& asked) {
    std::unique_lock lock(mutex);
    wake.wait_for(lock, kEvery, [&] { return ended || submitted.begun != 0; });
    next = submitted;
    submitted.begun = 0;
    asked = std::exchange(since, std::nullopt);
    return !ended;
}

void Sounds::Shared::played(const SoundFrame& now, const std::optional<SteadyClock::time_point>& asked) {
    if (now.begun == 0 || !asked) return;
    const double late_s = since_s(*asked);
    const std::lock_guard lock(mutex);
    ++totals.begun;
    late_sum_s += late_s;
    totals.late_s = std::max(totals.late_s, late_s);
    totals.mean_late_s = late_sum_s / double(totals.begun);
}

void Sounds::Shared::silent() {
    const std::lock_guard lock(mutex);
    gone = true;
    totals.device.clear();
}

void Sounds::Shared::run(const Pose& stage_from_operator,
                         const std::shared_ptr<const ListenerPose>& listener_pose, const Opened& open,
                         const Say& say) {
    try {
        Speaker speaker = open();
        {
            const std::lock_guard lock(mutex);
            totals.device = speaker.name();
            totals.device_late_s = speaker.latency_s();
        }
        SoundFrame now;
        std::optional<SteadyClock::time_point> asked;
        while (waitForNext(now, asked)) {
            const std::optional<Pose> head = listener_pose ? listener_pose->load() : std::nullopt;
            speaker.listen(head.value_or(stage_from_operator));
            speaker.play(now);
            played(now, asked);
            if (speaker.connected()) continue;
            silent();
            say("the sound device was lost; the attempt continues without sound");
            return;
        }
    } catch (const SoundError& e) {
        silent();
        say(std::string("no sound: ") + e.what() + "; the attempt continues without sound");
    }
}

Sounds::Sounds(const Pose& stage_from_operator, std::shared_ptr<const ListenerPose> listener_pose,
               Opened open, Say say)
    : shared_(std::make_shared<Shared>()) {
    std::thread([shared = shared_, stage_from_operator, listener_pose = std::move(listener_pose),
                 open = std::move(open), say = std::move(say)] {
        shared->run(stage_from_operator, listener_pose, open, say);
        shared->left.set_value();
    }).detach();
}

Sounds::~Sounds() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->ended = true;
    }
    shared_->wake.notify_all();
    shared_->left.get_future().wait_for(kPatience);
}

void Sounds::submit(const SoundFrame& frame) {
    {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->gone) return;
        const std::uint32_t waiting = shared_->submitted.begun;
        shared_->submitted = frame;
        shared_->submitted.begun |= waiting;
        if (frame.begun != 0 && !shared_->since) shared_->since = SteadyClock::now();
    }
    if (frame.begun != 0) shared_->wake.notify_one();
}

SoundTotals Sounds::totals() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->totals;
}

}  // namespace stylet::trainer
