#include <cmath>

#include "tests/xr/mock/client/pictures.h"

namespace mock_test {
namespace {

constexpr auto kHidden = XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR;
constexpr auto kVisible = XR_VISIBILITY_MASK_TYPE_VISIBLE_TRIANGLE_MESH_KHR;
constexpr auto kLoop = XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR;

struct Mask {
    std::vector<XrVector2f> vertices;
    std::vector<std::uint32_t> indices;

    double turn(std::size_t i, std::size_t j, std::size_t k) const {
        const XrVector2f &a = vertices[indices[i]], &b = vertices[indices[j]], &c = vertices[indices[k]];
        return (double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x);
    }
    double triangleArea() const {  // all triangles are counter-clockwise
        double area = 0;
        for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
            EXPECT_GE(turn(i, i + 1, i + 2), -1e-6);
            area += turn(i, i + 1, i + 2) / 2;
        }
        return area;
    }
    double loopArea() const {
        double area = 0;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            const XrVector2f &a = vertices[indices[i]], &b = vertices[indices[(i + 1) % indices.size()]];
            area += (double{a.x} * b.y - double{b.x} * a.y) / 2;
        }
        return area;
    }
};

// Fields of view with a tangent of 1 on all sides.
std::string scenarioWith(const std::string& eyes, const std::string& more = "") {
    return R"({ "version": 2, "eyes": { "ipd_m": 0.06, "recommended_size": [200, 200],
        "left_fov_rad": [-0.7853981634, 0.7853981634, 0.7853981634, -0.7853981634],
        "right_fov_rad": [-0.7853981634, 0.7853981634, 0.7853981634, -0.7853981634])" +
           eyes + "}" + more + "}";
}

class VisibilityMask : public PictureTest {
  protected:
    XrResult get(std::uint32_t view, XrVisibilityMaskTypeKHR type, XrVisibilityMaskKHR& mask,
                 XrViewConfigurationType configuration = kStereo) {
        return load<PFN_xrGetVisibilityMaskKHR>(instance_, "xrGetVisibilityMaskKHR")(session_, configuration,
                                                                                     view, type, &mask);
    }
    Mask mask(std::uint32_t view, XrVisibilityMaskTypeKHR type) {
        auto counts = makeStruct<XrVisibilityMaskKHR>(XR_TYPE_VISIBILITY_MASK_KHR);
        EXPECT_EQ(get(view, type, counts), XR_SUCCESS);
        Mask found{std::vector<XrVector2f>(counts.vertexCountOutput),
                   std::vector<std::uint32_t>(counts.indexCountOutput)};
        counts.vertexCapacityInput = counts.vertexCountOutput;
        counts.indexCapacityInput = counts.indexCountOutput;
        counts.vertices = found.vertices.data();
        counts.indices = found.indices.data();
        EXPECT_EQ(get(view, type, counts), XR_SUCCESS);
        for (const std::uint32_t index : found.indices)
            EXPECT_LT(index, found.vertices.size());
        return found;
    }
};

TEST_F(VisibilityMask, HiddenAndVisibleMakeUpTheFieldOfView) {
    // The lens is a regular polygon with 32 corners. It extends beyond the field of view on three sides.
    setScript(scenarioWith(R"(, "lens": { "radius": 1.2, "centre": [-0.3, 0.1] })"));
    startSession();
    for (std::uint32_t view = 0; view < 2; ++view) {
        const Mask hidden = mask(view, kHidden), visible = mask(view, kVisible), loop = mask(view, kLoop);
        EXPECT_GT(hidden.triangleArea(), 0.1);
        EXPECT_NEAR(hidden.triangleArea() + visible.triangleArea(), 4, 1e-5);
        EXPECT_NEAR(loop.loopArea(), visible.triangleArea(), 1e-5);
        EXPECT_EQ(loop.indices.size(), loop.vertices.size());
        for (const XrVector2f& corner : loop.vertices) {
            EXPECT_LE(std::abs(corner.x), 1 + 1e-6);
            EXPECT_LE(std::hypot(corner.x - (view == 0 ? -0.3 : 0.3), corner.y - 0.1), 1.2 + 1e-6);
        }
    }
}

TEST_F(VisibilityMask, MatchesASquareLens) {
    setScript(scenarioWith(R"(, "lens": { "outline": [[-0.5, -0.5], [2, -0.5], [2, 0.5], [-0.5, 0.5]] })"));
    startSession();
    EXPECT_NEAR(mask(0, kVisible).triangleArea(), 1.5, 1e-6);
    EXPECT_NEAR(mask(0, kHidden).triangleArea(), 2.5, 1e-6);
    double least = 1, most = -1;
    for (const XrVector2f& corner : mask(1, kLoop).vertices) {  // the right eye's mask is mirrored
        least = std::min(least, double{corner.x});
        most = std::max(most, double{corner.x});
    }
    EXPECT_NEAR(least, -1, 1e-6);
    EXPECT_NEAR(most, 0.5, 1e-6);
}

TEST_F(VisibilityMask, IsEmptyWithoutALensAndHidesNothingBehindAWideOne) {
    setScript(scenarioWith(""));
    startSession();
    for (const auto type : {kHidden, kVisible, kLoop})
        EXPECT_TRUE(mask(0, type).indices.empty());
    EXPECT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
    setScript(scenarioWith(R"(, "lens": { "radius": 5 })"));
    vkDestroyDevice(vk_device_, nullptr);
    startSession();
    EXPECT_TRUE(mask(0, kHidden).indices.empty());
    EXPECT_NEAR(mask(0, kVisible).triangleArea(), 4, 1e-6);
    EXPECT_EQ(mask(0, kLoop).indices.size(), 4U);
}

TEST_F(VisibilityMask, ChecksItsArguments) {
    setScript(scenarioWith(R"(, "lens": { "radius": 1 })"));
    startSession();
    auto out = makeStruct<XrVisibilityMaskKHR>(XR_TYPE_VISIBILITY_MASK_KHR);
    EXPECT_EQ(get(2, kHidden, out), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(get(0, static_cast<XrVisibilityMaskTypeKHR>(0), out), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(get(0, static_cast<XrVisibilityMaskTypeKHR>(4), out), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(get(0, kHidden, out, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO),
              XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    auto wrong = makeStruct<XrVisibilityMaskKHR>(XR_TYPE_VIEW);
    EXPECT_EQ(get(0, kHidden, wrong), XR_ERROR_VALIDATION_FAILURE);
    ASSERT_EQ(get(0, kLoop, out), XR_SUCCESS);
    const std::uint32_t count = out.vertexCountOutput;
    std::vector<XrVector2f> vertices(count);
    std::vector<std::uint32_t> indices(count);
    out.vertices = vertices.data();
    out.indices = indices.data();
    out.vertexCapacityInput = 1;
    EXPECT_EQ(get(0, kLoop, out), XR_SUCCESS);  // the other capacity is 0, so both are treated as 0
    EXPECT_EQ(vertices[0].x, 0);
    out.indexCapacityInput = count;
    EXPECT_EQ(get(0, kLoop, out), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(out.vertexCountOutput, count);
    out.vertexCapacityInput = count;
    out.indexCapacityInput = 1;
    EXPECT_EQ(get(0, kLoop, out), XR_ERROR_SIZE_INSUFFICIENT);
}

TEST_F(VisibilityMask, ChangesWithTheScenarioAndNotifiesEveryView) {
    setScript(
        scenarioWith(R"(, "lens": { "radius": 1 })",
                     R"(, "events": [ { "frame": 5, "visibility_mask": { "lens": { "radius": 0.5 } } } ])"));
    startFocused();
    const double before = mask(0, kVisible).triangleArea();
    EXPECT_FALSE(poll(XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR));
    frame();
    frame();
    for (std::uint32_t view = 0; view < 2; ++view) {
        const auto event = poll(XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR);
        ASSERT_TRUE(event);
        const auto& changed = reinterpret_cast<const XrEventDataVisibilityMaskChangedKHR&>(*event);
        EXPECT_EQ(changed.session, session_);
        EXPECT_EQ(changed.viewConfigurationType, kStereo);
        EXPECT_EQ(changed.viewIndex, view);
    }
    EXPECT_NEAR(mask(0, kVisible).triangleArea(), before / 4, 1e-5);
}

TEST_F(VisibilityMask, BlackensPicturesOnRequest) {
    setScript(scenarioWith(
        R"(, "pictures_through_lens": true, "lens": { "outline": [[-0.5, -0.25], [0.75, -0.25], [0.75, 0.5], [-0.5, 0.5]] })"));
    startFocused();
    const Swapchain white = picture(4, 4, std::vector(16, Rgba{255, 255, 255, 255}));
    const auto wall =
        quadLayer(createSpace(XR_REFERENCE_SPACE_TYPE_VIEW), white, {{0, 0, 0, 1}, {0, 0, -1}}, {9, 9});
    label("capture:lens");
    frame({header(wall)});
    const Picture left = readPicture(file("lens_left.png")), right = readPicture(file("lens_right.png"));
    ASSERT_EQ(left.width, 200);
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 200; ++x) {
            const bool in_rows = y >= 50 && y < 125;
            const Rgb lit{255, 255, 255}, dark{0, 0, 0};
            ASSERT_EQ(left.at(x, y), in_rows && x >= 50 && x < 175 ? lit : dark) << x << " " << y;
            ASSERT_EQ(right.at(x, y), in_rows && x >= 25 && x < 150 ? lit : dark) << x << " " << y;
        }
    }
}

}  // namespace
}  // namespace mock_test
