// XRMOCK_LOG: the contents of the log, its byte-by-byte reproducibility, and its cost.
#include <chrono>
#include <fstream>
#include <iterator>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

using nlohmann::json;

class Log : public MockTest {
  protected:
    // Plays a short scenario with one projection layer per frame. Returns the log's text.
    std::string play(const std::string& name) {
        setVariable("XRMOCK_LOG", file(name).string());
        setScript(R"({"version": 2, "head": [{"t_s": 0, "position": [0, 1.6, 0]},
            {"t_s": 2, "position": [0.3, 1.6, 0]}], "events": [{"frame": 6, "recenter": {}},
            {"frame": 8, "session": "visible"}, {"frame": 9, "refuse": {"call": "xrLocateViews",
            "result": "XR_ERROR_RUNTIME_FAILURE"}}]})");
        startFocused();
        auto info = swapchainInfo();
        const Swapchain swapchain = createSwapchain(info);
        for (int i = 0; i < 10; ++i)
            projectionFrame(swapchain);
        destroyAll();
        return text(name);
    }
    std::string text(const std::string& name) {
        std::ifstream in(file(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    std::vector<json> lines(const std::string& log) {
        std::vector<json> result;
        std::istringstream in(log);
        for (std::string line; std::getline(in, line);)
            result.push_back(json::parse(line));
        return result;
    }
};

TEST_F(Log, WritesCallsAndFrames) {
    int frames = 0, ends = 0, refused = 0, rendered = 0;
    std::int64_t time = 0;
    for (const json& line : lines(play("log.jsonl"))) {
        if (line.contains("frame")) {
            ++frames;
            ASSERT_EQ(line["frame"], frames);
            if (frames <= 3) continue;  // frames of startFocused() have no layers
            const json& view = line["layers"].at(0)["views"].at(1);
            EXPECT_EQ(line["layers"][0]["type"], "projection");
            EXPECT_EQ(view["image"]["rect"], (json::array({0, 0, 64, 48})));
            EXPECT_EQ(view["image"]["array_index"], 1);
            EXPECT_EQ(view["image"]["format"], VK_FORMAT_R8G8B8A8_SRGB);
            EXPECT_EQ(view["pose"].size(), 7U);
            continue;
        }
        EXPECT_GE(line["time"], time);
        time = line["time"];
        EXPECT_EQ(line["thread"], 1);
        ends += line["call"] == "xrEndFrame";
        refused += line["result"] == "XR_ERROR_RUNTIME_FAILURE";
        rendered += line["call"] == "xrWaitFrame" && line["args"].back()["should_render"] == true;
    }
    EXPECT_EQ(frames, 13);
    EXPECT_EQ(ends, 13);
    EXPECT_EQ(refused, 1);
    EXPECT_GT(rendered, 5);
}

TEST_F(Log, TextsOfAnyBytesAreLogged) {
    setVariable("XRMOCK_LOG", file("log.jsonl").string());
    startSession();
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(xrStringToPath(instance_, "/\"na\xc3\xafve\\", &path), XR_ERROR_PATH_FORMAT_INVALID);
    EXPECT_EQ(xrStringToPath(instance_, "/\xff\n", &path), XR_ERROR_PATH_FORMAT_INVALID);
    destroyInstance();
    std::vector<std::string> texts;
    for (const json& line : lines(text("log.jsonl")))
        if (line["call"] == "xrStringToPath") texts.push_back(line["args"][1]);
    const std::vector<std::string> expected{"/\"na\xc3\xafve\\", "/\xef\xbf\xbd\n"};
    EXPECT_EQ(texts, expected);
}

TEST_F(Log, TwoRunsGiveTheSameBytes) {
    const std::string first = play("first.jsonl");
    EXPECT_GT(first.size(), 10'000U);
    EXPECT_EQ(first, play("second.jsonl"));
}

TEST_F(Log, ALaterInstanceAppendsToTheSameFile) {
    const std::string first = play("log.jsonl");
    const std::string both = play("log.jsonl");
    EXPECT_TRUE(both.starts_with(first));
    int instances = 0, frames = 0;
    for (const json& line : lines(both)) {
        instances += line.value("call", "") == "xrCreateInstance";
        frames += line.contains("frame");
    }
    EXPECT_EQ(instances, 2);
    EXPECT_EQ(frames, 26);
}

TEST_F(Log, CostsLittle) {
    setVariable("XRMOCK_LOG", file("log.jsonl").string());
    startFocused();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const auto start = std::chrono::steady_clock::now();
    constexpr int kFrames = 500;
    for (int i = 0; i < kFrames; ++i)
        projectionFrame(swapchain);
    const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
    std::error_code error;
    RecordProperty("frame_with_log_us", static_cast<int>(spent.count() / kFrames));
    // Nine lines per frame, of bounded length.
    EXPECT_LT(std::filesystem::file_size(file("log.jsonl"), error) / kFrames, 4096U);
}

}  // namespace
}  // namespace mock_test
