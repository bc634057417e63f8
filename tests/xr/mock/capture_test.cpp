#include <fstream>
#include <iterator>
#include <string>

#include "tests/xr/mock/client/pictures.h"

namespace mock_test {
namespace {

class Capture : public PictureTest {
  protected:
    void SetUp() override {
        PictureTest::SetUp();
        startFocused();
    }

    // Fills the left half of each layer with one colour and the right half with another.
    void drawHalves(const Swapchain& swapchain, const std::vector<std::array<Rgba, 2>>& layers) {
        std::vector<Rgba> texels;
        for (const auto& halves : layers)
            for (std::uint32_t i = 0; i < swapchain.width * swapchain.height; ++i)
                texels.push_back(halves[i % swapchain.width < swapchain.width / 2 ? 0 : 1]);
        draw(swapchain, texels);
    }
};

constexpr Rgba kA{10, 20, 30, 255}, kB{200, 100, 50, 0}, kC{1, 2, 3, 4}, kD{250, 251, 252, 253};
constexpr Rgb kRgbA{10, 20, 30}, kRgbB{200, 100, 50}, kRgbC{1, 2, 3}, kRgbD{250, 251, 252};

TEST_F(Capture, WritesBothLayersUnchanged) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    for (int i = 0; i < 5; ++i) {  // covers every image of the swapchain, some of them twice
        drawHalves(swapchain, {{kA, kB}, {kC, kD}});
        label("capture:skin");
        projectionFrame({swapchain.handle, {{0, 0}, {64, 48}}, 0}, {swapchain.handle, {{0, 0}, {64, 48}}, 1});
        const Picture left = readPicture(file("skin_left.png"));
        const Picture right = readPicture(file("skin_right.png"));
        ASSERT_EQ(left.width, 64);
        ASSERT_EQ(left.height, 48);
        ASSERT_EQ(right.width, 64);
        for (int y = 0; y < 48; ++y) {
            for (int x = 0; x < 64; ++x) {
                ASSERT_EQ(left.at(x, y), x < 32 ? kRgbA : kRgbB);
                ASSERT_EQ(right.at(x, y), x < 32 ? kRgbC : kRgbD);
            }
        }
        std::filesystem::remove(file("skin_left.png"));
    }
}

TEST_F(Capture, HonoursTheRectangle) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.arraySize = 1;
    const Swapchain swapchain = createSwapchain(info);
    drawHalves(swapchain, {{kA, kB}});
    label("capture:rect");
    projectionFrame({swapchain.handle, {{30, 7}, {4, 9}}, 0}, {swapchain.handle, {{63, 47}, {1, 1}}, 0});
    const Picture left = readPicture(file("rect_left.png"));
    ASSERT_EQ(left.width, 4);
    ASSERT_EQ(left.height, 9);
    EXPECT_EQ(left.at(1, 0), kRgbA);
    EXPECT_EQ(left.at(2, 8), kRgbB);
    const Picture right = readPicture(file("rect_right.png"));
    ASSERT_EQ(right.width, 1);
    EXPECT_EQ(right.at(0, 0), kRgbB);
}

TEST_F(Capture, WritesTheChannelsInRgbOrder) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.format = VK_FORMAT_B8G8R8A8_SRGB;
    const Swapchain swapchain = createSwapchain(info);
    drawHalves(swapchain, {{kA, kB}, {kC, kD}});
    label("capture:bgr");
    projectionFrame({swapchain.handle, {{0, 0}, {64, 48}}, 0}, {swapchain.handle, {{0, 0}, {64, 48}}, 1});
    EXPECT_EQ(readPicture(file("bgr_left.png")).at(0, 0), (Rgb{30, 20, 10}));
}

TEST_F(Capture, CapturesOnlyTheNextFrameWithALayer) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    label("capture:later");
    frame();
    EXPECT_FALSE(std::filesystem::exists(file("later_left.png")));
    drawHalves(swapchain, {{kA, kA}, {kA, kA}});
    projectionFrame(whole, whole);
    EXPECT_EQ(readPicture(file("later_left.png")).at(5, 5), kRgbA);
    drawHalves(swapchain, {{kB, kB}, {kB, kB}});
    projectionFrame(whole, whole);
    EXPECT_EQ(readPicture(file("later_left.png")).at(5, 5), kRgbA);
}

TEST_F(Capture, RefusesNamesThatLeaveTheFolder) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    drawHalves(swapchain, {{kA, kA}, {kA, kA}});
    for (const char* name : {"capture:../out", "capture:", "capture:.hidden", "capture:a b", "other:x"}) {
        label(name);
        projectionFrame(whole, whole);
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file("")), {}), 0);
}

TEST_F(Capture, AWriteErrorDoesNotFailTheFrame) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    drawHalves(swapchain, {{kA, kA}, {kA, kA}});
    std::filesystem::create_directory(file("taken_left.png"));  // this name cannot be written
    label("capture:taken");
    projectionFrame(whole, whole);
    EXPECT_TRUE(std::filesystem::is_directory(file("taken_left.png")));
    label("capture:free");
    projectionFrame(whole, whole);
    EXPECT_EQ(readPicture(file("free_left.png")).at(0, 0), kRgbA);
}

// A capture folder that is a file. The first failure of the run is printed and logged, no later one.
TEST_F(Capture, AFolderThatCannotBeCreatedIsReportedOnce) {
    destroyAll();
    const std::string taken = file("taken").string();
    std::ofstream(taken) << "no folder";
    setVariable("XRMOCK_CAPTURE", taken);
    setVariable("XRMOCK_LOG", file("log.jsonl").string());
    testing::internal::CaptureStderr();
    startFocused();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    for (const char* name : {"capture:first", "capture:second"}) {
        label(name);
        projectionFrame(swapchain);
    }
    vkDeviceWaitIdle(vk_device_);
    destroyInstance();
    const std::string printed = testing::internal::GetCapturedStderr();
    const std::string reason =
        "XRMOCK_CAPTURE: capture first: " + taken + " cannot be created: Not a directory";
    EXPECT_EQ(printed, "xrmock: " + reason + "\n");
    std::ifstream in(file("log.jsonl"));
    const std::string log{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    EXPECT_NE(log.find("{\"error\":\"" + reason + "\"}\n"), std::string::npos);
    EXPECT_EQ(log.find("second: "), std::string::npos);
}

// Without any capture, only frames.json cannot be written.
TEST_F(Capture, StatisticsThatCannotBeWrittenAreReported) {
    std::filesystem::create_directory(file("frames.json"));
    vkDeviceWaitIdle(vk_device_);
    testing::internal::CaptureStderr();
    destroyInstance();
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "xrmock: XRMOCK_CAPTURE: " + file("").string() + "frames.json cannot be written\n");
}

TEST_F(Capture, CountsFramesAtTheEnd) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    drawHalves(swapchain, {{kA, kA}, {kA, kA}});
    label("capture:one");
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    projectionFrame(whole, whole);
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    vkDeviceWaitIdle(vk_device_);
    destroyInstance();
    std::stringstream text;
    text << std::ifstream(file("frames.json")).rdbuf();
    EXPECT_NE(text.str().find("\"submitted\": 4,"), std::string::npos) << text.str();
    EXPECT_NE(text.str().find("\"discarded\": 1,"), std::string::npos);
    EXPECT_NE(text.str().find("\"captured\": 1,"), std::string::npos);
}

}  // namespace
}  // namespace mock_test
