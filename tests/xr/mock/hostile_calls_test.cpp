// Calls every function with arguments that no sensible program passes, from one thread and from eight.
// Nothing may crash, every result must be listed in the specification, and Vulkan must report no errors.
#include <iterator>
#include <random>
#include <thread>

#include "tests/xr/mock/client/hostile.h"

namespace mock_test {
namespace {

class HostileCalls : public MockTest {
  protected:
    void startAll() {
        startVulkan();
        shared_objects_.instance = instance_;
        shared_objects_.system = system_;
        shared_objects_.binding = binding();
    }
    SharedObjects shared_objects_;
};

TEST_F(HostileCalls, GetListedResults) {
    startAll();
    for (unsigned seed = 0; seed < 10; ++seed) {
        HostileCaller hostile(shared_objects_, seed);
        for (int i = 0; i < 6000 && !HasFailure(); ++i) {
            if (i % 4 == 0) hostile.callSensibly();
            hostile.callAny();
        }
    }
}

// Triggers every kind of scenario event repeatedly, while calls and frames are logged.
TEST_F(HostileCalls, GetListedResultsWhateverHappens) {
    constexpr const char* kEvents[] = {
        R"("session": "visible")",
        R"("session": "stopped")",
        R"("session": "focused")",
        R"("session_loss": {"lost_after_s": 0.05})",
        R"("session_loss": {"lost_after_s": 0})",
        R"("recenter": {"delay_s": 0.1})",
        R"("recenter": {"space": "stage", "pose_valid": false})",
        R"("recenter": {"space": "stationary"})",
        R"("head_tracked": false)",
        R"("head_tracked": true)",
        R"("refresh_hz": 60)",
        R"("user_presence": false)",
        R"("user_presence": true)",
        R"("frames": {"late": 3})",
        R"("frames": {"not_rendered": true, "count": 2})",
    };
    std::mt19937 random(7);
    std::string events;
    for (int i = 0; i < 400; ++i) {
        events += (i == 0 ? "{\"t_s\": " : ", {\"t_s\": ") + std::to_string(1 + i * 0.1) + ", " +
                  kEvents[random() % std::size(kEvents)] + "}";
    }
    setScript(
        R"({"version": 2, "headset": "simple", "offers": {"spaces": ["stage", "local_floor", "stationary"]},
                  "events": [)" +
        events + "]}");
    setVariable("XRMOCK_LOG", file("log.jsonl").string());
    startAll();
    HostileCaller hostile(shared_objects_, 8);
    for (int i = 0; i < 16'000 && !HasFailure(); ++i) {
        if (i % 4 == 0) hostile.callSensibly();
        hostile.callAny();
    }
}

TEST_F(HostileCalls, GetListedResultsFromEightThreads) {
    startAll();
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < 8; ++i) {
        threads.emplace_back([this, i] {
            const bool frames = i == 0;
            HostileCaller hostile(shared_objects_, 100 + i, frames);
            for (int call = 0; call < 10'000; ++call)
                if (frames && call % 2 == 0)
                    hostile.callSensibly();
                else
                    hostile.callAny();
        });
    }
    for (std::thread& thread : threads)
        thread.join();
}

}  // namespace
}  // namespace mock_test
