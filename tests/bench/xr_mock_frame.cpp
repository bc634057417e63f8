// The mock OpenXR runtime: the time of a composed picture and its error against a double-precision
// reference, and the time of a frame whose picture nobody requests. The benchmark uses the runtime through
// the loader, as applications do.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include <fmt/core.h>

#include "tests/bench/bench.h"
#include "tests/xr/mock/client/reference_compositor.h"

namespace stylet::bench {
namespace {

using namespace mock_test;

constexpr auto kSide_rad = float(std::numbers::pi / 4);
constexpr XrFovf kFov{-kSide_rad, kSide_rad, kSide_rad, -kSide_rad};
constexpr float kLeftEye_m = -0.03F;

// Reads the time from a message such as "composed the left eye: 640 x 640, 1 layers, 12.3 ms".
XRAPI_ATTR XrBool32 XRAPI_CALL note(XrDebugUtilsMessageSeverityFlagsEXT, XrDebugUtilsMessageTypeFlagsEXT,
                                    const XrDebugUtilsMessengerCallbackDataEXT* data, void* times_ms) {
    const char* last = std::strrchr(data->message, ',');
    if (last != nullptr) static_cast<std::vector<double>*>(times_ms)->push_back(std::atof(last + 1));
    return XR_FALSE;
}

class Client : public PictureTest {
  public:
    explicit Client(int side) {
        setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 0);
        validated_ = false;
        SetUp();
        const std::string size = std::to_string(side),
                          fov = "[-0.7853981634, 0.7853981634, 0.7853981634, -0.7853981634]";
        setScript(R"({ "version": 1, "eyes": { "ipd_m": 0.06, "recommended_size": [)" + size + ", " + size +
                  R"(], "left_fov_rad": )" + fov + R"(, "right_fov_rad": )" + fov + "} }");
        startFocused();
        view_ = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
        const XrDebugUtilsMessengerCreateInfoEXT info{XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                                      nullptr,
                                                      XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
                                                      XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
                                                      note,
                                                      &times_ms_};
        XrDebugUtilsMessengerEXT messenger = XR_NULL_HANDLE;
        load<PFN_xrCreateDebugUtilsMessengerEXT>(instance_, "xrCreateDebugUtilsMessengerEXT")(
            instance_, &info, &messenger);
    }
    ~Client() override { TearDown(); }
    void TestBody() override {}

    struct Composed {
        double first_ms, median_ms;
        Picture left;
    };
    Composed compose(const void* layer) {
        constexpr int kFrames = 6;
        for (int i = 0; i < kFrames; ++i) {
            label("capture:bench");
            frame({static_cast<const XrCompositionLayerBaseHeader*>(layer)});
        }
        if (times_ms_.size() != 2 * kFrames) throw std::runtime_error("a composition failed");
        return {times_ms_[0], median({times_ms_.begin() + 2, times_ms_.end()}),
                readPicture(file("bench_left.png"))};
    }

    // Frames whose pictures nobody requests. Each frame has a new image in every layer.
    void frames(int layers, std::vector<Row>& rows) {
        constexpr int kFrames = 500;
        const Swapchain swapchain = createSwapchain(swapchainInfo());
        const auto quad = quadLayer(view_, swapchain, {{0, 0, 0, 1}, {0, 0, -2}}, {1, 1});
        const std::vector submitted(std::size_t(layers),
                                    reinterpret_cast<const XrCompositionLayerBaseHeader*>(&quad));
        cycle(swapchain.handle);
        const XrTime start = frame(submitted).predictedDisplayTime;
        std::vector<double> times_ms;
        XrFrameState state{};
        for (int i = 0; i < kFrames; ++i) {
            const auto began = std::chrono::steady_clock::now();
            cycle(swapchain.handle);
            state = frame(submitted);
            times_ms.push_back(elapsed_ms(began));
        }
        const double off_ns =
            double(state.predictedDisplayTime - start - kFrames * state.predictedDisplayPeriod);
        rows.push_back({"xr.mock_frame.unseen", "quad layers", double(layers), median(times_ms),
                        std::abs(off_ns), "ns", "500 periods of the virtual clock",
                        "acquire, wait, release, xrWaitFrame, xrBeginFrame, xrEndFrame"});
    }

    XrSpace view() const { return view_; }
    using PictureTest::picture;

  private:
    XrSpace view_ = XR_NULL_HANDLE;
    std::vector<double> times_ms_;
};

void add(const char* kind, int side, const Client::Composed& composed, const ReferenceLayer& layer,
         std::vector<Row>& rows) {
    const Picture reference = composeReference({layer}, {{0, 0, 0, 1}, {kLeftEye_m, 0, 0}}, kFov, side, side);
    const Difference off = compare(composed.left, reference);
    const std::string text =
        fmt::format("per eye, waiting for the GPU; the first took {:.3g} ms; PSNR {:.1f} dB",
                    composed.first_ms, off.psnr_db);
    rows.push_back({std::string("xr.mock_frame.") + kind, "picture side [px]", double(side),
                    composed.median_ms, double(off.largest), "of 255", "double precision on the CPU", text});
}

void projection(int side, std::vector<Row>& rows) {
    Client client(side);
    const std::vector<Rgba> texels = pattern(side, side, 12);
    const Swapchain swapchain = client.picture(unsigned(side), unsigned(side), texels);
    const XrPosef submitted{turned(0.03, {0.6F, 0.8F, 0}), {kLeftEye_m, 0, 0}};
    std::array<XrCompositionLayerProjectionView, 2> views;
    views.fill({XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, submitted, kFov, whole(swapchain)});
    const XrCompositionLayerProjection layer{
        XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, client.view(), 2, views.data()};
    ReferenceLayer same{
        XR_TYPE_COMPOSITION_LAYER_PROJECTION, submitted, kFov, {}, 0, 0, 0, 0, texels, side, side};
    add("projection", side, client.compose(&layer), same, rows);
}

constexpr XrCompositionLayerFlags kBlend =
    XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT | XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;

void quad(int side, std::vector<Row>& rows) {
    Client client(side);
    const std::vector<Rgba> texels = pattern(512, 512, 12);
    XrCompositionLayerQuad layer = quadLayer(client.view(), client.picture(512, 512, texels),
                                             {turned(0.3, {0, 1, 0}), {0, 0, -1.5F}}, {3, 3});
    layer.layerFlags = kBlend;
    const ReferenceLayer same{
        XR_TYPE_COMPOSITION_LAYER_QUAD, layer.pose, {}, layer.size, 0, 0, 0, kBlend, texels, 512, 512};
    add("quad", side, client.compose(&layer), same, rows);
}

void cylinder(int side, std::vector<Row>& rows) {
    Client client(side);
    const std::vector<Rgba> texels = pattern(1024, 512, 12);
    XrCompositionLayerCylinderKHR layer =
        cylinderLayer(client.view(), client.picture(1024, 512, texels), 1, 2, 1.2F);
    layer.layerFlags = kBlend;
    const ReferenceLayer same{
        XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR, kIdentity, {}, {}, 1, 2, 1.2F, kBlend, texels, 1024, 512};
    add("cylinder", side, client.compose(&layer), same, rows);
}

void run(std::vector<Row>& rows) {
    for (const auto& measure : {projection, quad, cylinder}) {
        for (const int side : {256, 640, 1280})
            measure(side, rows);
    }
    for (const int layers : {0, 1, 16}) {
        Client client(640);
        client.frames(layers, rows);
    }
}

const Registration registration("xr.mock_frame", run);

}  // namespace
}  // namespace stylet::bench
