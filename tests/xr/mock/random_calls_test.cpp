// Calls in random order, from one thread and from several. Every call must return a result listed in the
// specification, and Vulkan must report no errors.
#include <atomic>
#include <random>
#include <thread>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

class RandomCalls : public MockTest {
  protected:
    // Frames and swapchain images, in any order. Calls xrWaitFrame only when it cannot block.
    void step(std::mt19937& random) {
        std::uint32_t index = 0;
        const XrSwapchainImageWaitInfo wait_info{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, 0};
        switch (random() % 14) {
            case 0:
                if (!waited_ && waitFrame() == XR_SUCCESS) waited_ = true;
                break;
            case 1:
                if (beginFrame() >= 0) waited_ = false;
                break;
            case 2:
                endFrame(static_cast<XrTime>(random() % 3) - 1);
                break;
            case 3:
                xrAcquireSwapchainImage(swapchain_, nullptr, &index);
                break;
            case 4:
                xrWaitSwapchainImage(swapchain_, &wait_info);
                break;
            case 5:
                xrReleaseSwapchainImage(swapchain_, nullptr);
                break;
            case 6:
                spaces_.push_back(createSpace(XR_REFERENCE_SPACE_TYPE_VIEW));
                break;
            case 7:
                destroyRandomSpace(random);
                break;
            case 8:
                submit(random);
                break;
            case 9:
                states();
                break;
            case 10:
                xrDestroySpace(handleFrom<XrSpace>(random));
                break;
            case 11:
                xrDestroySwapchain(handleFrom<XrSwapchain>(random));
                break;
            case 12:
                restartIfStopped(random);
                break;
            default:
                locate(random);
                break;
        }
    }
    template <class Handle>
    static Handle handleFrom(std::mt19937& random) {
        const std::uint64_t low = random(), high = random();
        return reinterpret_cast<Handle>(random() % 2 == 0 ? low % 64 : high << 32 | low);
    }
    void destroyRandomSpace(std::mt19937& random) {
        if (spaces_.empty()) return;
        const std::size_t i = random() % spaces_.size();
        EXPECT_EQ(xrDestroySpace(spaces_[i]), XR_SUCCESS);
        EXPECT_EQ(xrDestroySpace(spaces_[i]), XR_ERROR_HANDLE_INVALID);
        spaces_.erase(spaces_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    void submit(std::mt19937& random) {
        XrCompositionLayerQuad quad{
            XR_TYPE_COMPOSITION_LAYER_QUAD,
            nullptr,
            0,
            stage_,
            XR_EYE_VISIBILITY_BOTH,
            {swapchain_, {{0, 0}, {64, 48}}, static_cast<std::uint32_t>(random() % 3)},
            kIdentity,
            {1, 1}};
        quad.subImage.imageRect.extent.width = static_cast<std::int32_t>(random());
        endFrame(1, {header(quad)});
    }
    void restartIfStopped(std::mt19937& random) {
        if (random() % 8 == 0) xrRequestExitSession(session_);
        if (xrEndSession(session_) != XR_SUCCESS) return;
        waited_ = false;
        ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
        discardEvents();
        spaces_.clear();
        createAll();
    }
    void discardEvents() {
        while (poll(XR_TYPE_EVENT_DATA_BUFFER)) {
        }
    }
    void locate(std::mt19937& random) {
        auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
        const XrSpace base = random() % 4 == 0 ? handleFrom<XrSpace>(random) : stage_;
        xrLocateSpace(spaces_.empty() ? stage_ : spaces_.back(), base, static_cast<XrTime>(random()) - 1000,
                      &location);
    }
    void createAll() {
        const XrGraphicsBindingVulkan2KHR graphics = binding();
        ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
        stage_ = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
        swapchain_ = createSwapchain(swapchainInfo()).handle;
        const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr,
                                      XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
        ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
    }

    bool waited_ = false;
    XrSwapchain swapchain_ = XR_NULL_HANDLE;
    std::vector<XrSpace> spaces_;
};

TEST_F(RandomCalls, LeaveTheRuntimeConsistent) {
    startVulkan();
    createAll();
    std::mt19937 random(1);
    for (int i = 0; i < 20'000; ++i)
        step(random);
}

TEST_F(RandomCalls, FromManyThreads) {
    startFocused();
    std::atomic<int> located = 0;
    std::vector<std::thread> threads;
    for (unsigned seed = 0; seed < 4; ++seed) {
        threads.emplace_back([&, seed] {
            std::mt19937 random(seed);
            std::vector<XrSpace> own;
            for (int i = 0; i < 2000; ++i) {
                const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr,
                                                      XR_REFERENCE_SPACE_TYPE_VIEW, kIdentity};
                XrSpace space = XR_NULL_HANDLE;
                if (xrCreateReferenceSpace(session_, &info, &space) == XR_SUCCESS) own.push_back(space);
                auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
                if (xrLocateSpace(own[random() % own.size()], stage_, 1, &location) == XR_SUCCESS) ++located;
                XrPath atom = XR_NULL_PATH;
                xrStringToPath(instance_, ("/t" + std::to_string(random() % 100)).c_str(), &atom);
                if (own.size() > 20) {
                    xrDestroySpace(own.back());
                    own.pop_back();
                }
            }
        });
    }
    for (int i = 0; i < 200; ++i)
        frame();
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(located, 8000);
}

}  // namespace
}  // namespace mock_test
