// Every function with arguments that no sensible program gives, from one thread and from eight: nothing
// crashes, every result is one that the specification lists for the function, and Vulkan stays content.
#include <thread>

#include "hostile.h"

namespace mock_test {
namespace {

class HostileCalls : public MockTest {
  protected:
    void startAll() {
        startVulkan();
        surroundings_.instance = instance_;
        surroundings_.system = system_;
        surroundings_.binding = binding();
    }
    Surroundings surroundings_;
};

TEST_F(HostileCalls, GetListedResults) {
    startAll();
    for (unsigned seed = 0; seed < 10; ++seed) {
        Hostile hostile(surroundings_, seed);
        for (int i = 0; i < 6000 && !HasFailure(); ++i) {
            if (i % 4 == 0) hostile.behave();
            hostile.callAny();
        }
    }
}

TEST_F(HostileCalls, GetListedResultsFromEightThreads) {
    startAll();
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < 8; ++i) {
        threads.emplace_back([this, i] {
            const bool frames = i == 0;
            Hostile hostile(surroundings_, 100 + i, frames);
            for (int call = 0; call < 10'000; ++call) {
                if (frames && call % 2 == 0) {
                    hostile.behave();
                } else {
                    hostile.callAny();
                }
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
}

}  // namespace
}  // namespace mock_test
