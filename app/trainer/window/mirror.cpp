#include "app/trainer/window/mirror.h"

#include <fmt/core.h>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include "app/trainer/stores/console.h"
#include "app/trainer/window/app_window.h"
#include "app/trainer/window/window_content.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kOpenPatience = 5s, kClosePatience = 1s;
constexpr double kPoll_s = 1.0 / 60.0;
// A software renderer needs the processor for drawing and for presenting, so pictures are presented less
// often.
constexpr auto kPresentEvery = 0ms, kProcessorEvery = 100ms;

// Guards calls into the window system, which may never return. During such a call the owner may abandon the
// thread. If the call returns after that, the thread sleeps forever.
class Gate {
  public:
    template <typename Call>
    auto outside(const Call& call) {
        where_.store(Where::outside);
        struct Back {
            Gate& gate;
            ~Back() { gate.comeBack(); }
        } const back{*this};
        return call();
    }
    // Called by the owner. Returns true if the thread is in such a call. The thread is then abandoned and
    // never uses the attempt again.
    bool leave() {
        Where expected = Where::outside;
        return where_.compare_exchange_strong(expected, Where::left);
    }

  private:
    enum class Where : std::uint8_t { inside, outside, left };
    void comeBack() {
        Where expected = Where::outside;
        if (where_.compare_exchange_strong(expected, Where::inside)) return;
        while (true)
            std::this_thread::sleep_for(24h);
    }
    std::atomic<Where> where_{Where::inside};
};

// Deleter for objects whose destructors call the window system.
struct GateDeleter {
    Gate* gate = nullptr;
    template <typename T>
    void operator()(T* thing) const {
        gate->outside([&] { delete thing; });
    }
};
template <typename T>
using Outside = std::unique_ptr<T, GateDeleter>;

}  // namespace

struct Mirror::Impl {
    Impl(const patient::Patient& patient_in, const patient::PlannedPath& path_in,
         const MirrorSettings& settings_in)
        : patient(patient_in), path(path_in), settings(settings_in) {}

    void run();
    void show();

    const patient::Patient& patient;
    const patient::PlannedPath path;
    const MirrorSettings settings;
    MirrorChannels channels;
    Gate gate;
    std::atomic<bool> stop{false};
    std::atomic<std::uint64_t> shown{0}, messages{0};
    std::promise<std::string> opened;  // empty, or the reason why the window did not open
    bool told = false;                 // `opened` was set: the window is open
    std::promise<void> done;
    std::thread thread;
};

// Window thread.
void Mirror::Impl::run() {
    try {
        show();
    } catch (const std::exception& e) {
        if (told)
            printMessage(fmt::format("the window was lost: {}; the attempt continues without it", e.what()));
        else
            opened.set_value(e.what());
    }
    channels.open.store(false);
    done.set_value();
}

void Mirror::Impl::show() {
    const Outside<AppWindow> window(
        gate.outside([&] { return new AppWindow("Stylet", settings.width, settings.height); }), {&gate});
    render::Gpu gpu({.validation = settings.pictures.config.validation,
                     .pipeline_cache = settings.pipeline_cache,
                     .instance_extensions = gate.outside([&] { return window->instanceExtensions(); }),
                     .device_extensions = {VK_KHR_SWAPCHAIN_EXTENSION_NAME}});
    const Outside<render::Presenter> presenter(
        gate.outside([&] { return new render::Presenter(gpu, window->makeSurface(*gpu.instance())); }),
        {&gate});
    WindowContent shows(patient, path, settings, channels, gpu, *presenter);
    channels.open.store(true);
    told = true;
    opened.set_value("");
    const auto every = gpu.isSoftware() ? kProcessorEvery : kPresentEvery;
    auto next = SteadyClock::now();
    std::string title;
    bool waiting = false;  // the display has not accepted the last picture yet; until then nothing is drawn
    while (!stop.load()) {
        const WindowEvents events = gate.outside([&] { return window->poll(kPoll_s); });
        if (events.lost) throw WindowError("its display is gone");
        if (events.closed) break;
        const bool same = shows.handleEvents(events);
        if (!events.exposed && SteadyClock::now() < next) continue;
        if (!(waiting && same) && !shows.update()) continue;
        if (const std::string now = shows.title(); now != title)
            gate.outside([&] { window->setTitle(title = now); });
        waiting = !gate.outside([&] { return shows.present(); });
        if (!waiting) ++shown;
        messages.store(gpu.validationMessages());
        next = SteadyClock::now() + every;
    }
}

Mirror::Mirror(const patient::Patient& patient, const patient::PlannedPath& path,
               const MirrorSettings& settings)
    : impl_(std::make_unique<Impl>(patient, path, settings)) {
    auto opened = impl_->opened.get_future();
    impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
    if (opened.wait_for(kOpenPatience) != std::future_status::ready && impl_->gate.leave()) {
        impl_->thread.detach();
        impl_.release();  // still used by the abandoned thread
        throw WindowError("no window: the display does not answer");
    }
    const std::string why_not = opened.get();
    if (why_not.empty()) return;
    impl_->thread.join();
    throw WindowError(why_not);
}

Mirror::~Mirror() {
    impl_->stop.store(true);
    auto done = impl_->done.get_future();
    while (done.wait_for(kClosePatience) != std::future_status::ready) {
        if (!impl_->gate.leave()) continue;  // the thread is running and will see `stop`
        impl_->thread.detach();
        impl_.release();
        return;
    }
    impl_->thread.join();
}

MirrorChannels& Mirror::channels() {
    return impl_->channels;
}
std::uint64_t Mirror::shown() const {
    return impl_->shown.load();
}
std::uint64_t Mirror::validationMessages() const {
    return impl_->messages.load();
}

}  // namespace stylet::trainer
