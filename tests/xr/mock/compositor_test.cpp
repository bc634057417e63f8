// Compares the eyes' pictures with computed positions and colours, then with the double-precision reference.
// Vulkan's validation layer, with synchronization checks, observes every composition (client.cpp).
#include <cmath>
#include <numbers>

#include "tests/xr/mock/client/reference_compositor.h"

namespace mock_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr Rgba kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 255},
    kWhite{255, 255, 255, 255};
constexpr Rgb kBlack{0, 0, 0};
constexpr int kSize = 200;  // picture size, with a field of view of 90 degrees in both directions

Rgb rgb(const Rgba& c) {
    return {c[0], c[1], c[2]};
}

class Composition : public PictureTest {
  protected:
    // The head is turned and away from the origin. One pixel is 0.01 in the tangent of the view angle.
    void begin(const std::string& more = "") {
        setScript(R"({ "version": 2, "eyes": { "ipd_m": 0.06, "recommended_size": [200, 200],
            "left_fov_rad": [-0.7853981634, 0.7853981634, 0.7853981634, -0.7853981634],
            "right_fov_rad": [-0.7853981634, 0.7853981634, 0.7853981634, -0.7853981634] },
            "head": [ { "t_s": 0, "position": [0.3, 1.6, -0.2], "orientation": [0.1, 0.7, 0.1, 0.7] } ])" +
                  more + "}");
        startFocused();
        view_ = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    }

    Swapchain solid(Rgba colour) { return picture(4, 4, std::vector(16, colour)); }

    XrCompositionLayerQuad quad(const Swapchain& swapchain, XrVector3f position, XrExtent2Df size) {
        return quadLayer(view_, swapchain, {{0, 0, 0, 1}, position}, size);
    }
    XrCompositionLayerCylinderKHR cylinder(const Swapchain& swapchain, float radius, double angle,
                                           float aspect) {
        return cylinderLayer(view_, swapchain, radius, static_cast<float>(angle), aspect);
    }

    // The pictures of both eyes with these layers.
    template <class... Layers>
    std::array<Picture, 2> seen(const Layers&... layers) {
        for (const char* name : {"seen_left.png", "seen_right.png"})
            std::filesystem::remove(file(name));
        label("capture:seen");
        frame({header(layers)...});
        return {readPicture(file("seen_left.png")), readPicture(file("seen_right.png"))};
    }
    // Tangents of a pixel's ray.
    static double across(int x) { return (x + 0.5) / 100 - 1; }
    static double up(int y) { return 1 - (y + 0.5) / 100; }

    XrSpace view_ = XR_NULL_HANDLE;
};

template <class Inside>
int expectCovered(const Picture& picture, Rgb colour, Inside inside) {
    EXPECT_EQ(picture.width, kSize);
    EXPECT_EQ(picture.height, kSize);
    int covered = 0, wrong = 0;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const bool is_inside = inside(x, y);
            covered += is_inside ? 1 : 0;
            wrong += picture.at(x, y) != (is_inside ? colour : kBlack) ? 1 : 0;
        }
    }
    EXPECT_EQ(wrong, 0);
    return covered;
}

void expectNear(Rgb a, Rgb b) {
    for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(a[k], b[k], 1) << "channel " << k;
}

TEST_F(Composition, AQuadCoversExactlyItsPixelsInEachEye) {
    begin();
    const auto eyes = seen(quad(solid(kRed), {0.11F, 0.19F, -2}, {1, 0.5F}));
    for (int eye = 0; eye < 2; ++eye) {
        const double eye_x = eye == 0 ? -0.03 : 0.03;
        const int covered = expectCovered(eyes[static_cast<std::size_t>(eye)], rgb(kRed), [&](int x, int y) {
            const double hit_x = 2 * across(x) + eye_x, hit_y = 2 * up(y);
            return std::abs(hit_x - 0.11) <= 0.5 && std::abs(hit_y - 0.19) <= 0.25;
        });
        EXPECT_EQ(covered, 50 * 25);
    }
    // Parallax: an eye distance of 60 mm is 3 pixels at 2 m.
    EXPECT_EQ(eyes[0].at(82, 90), rgb(kRed));
    EXPECT_EQ(eyes[0].at(81, 90), kBlack);
    EXPECT_EQ(eyes[1].at(79, 90), rgb(kRed));
    EXPECT_EQ(eyes[1].at(78, 90), kBlack);
}

TEST_F(Composition, AQuadIsUprightAndVisibleOnlyFromItsFront) {
    begin();
    const Swapchain corners = picture(2, 2, {kRed, kGreen, kBlue, kWhite});
    XrCompositionLayerQuad shown = quad(corners, {0, 0, -2}, {2, 2});
    const Picture left = seen(shown)[0];
    EXPECT_EQ(left.at(55, 55), rgb(kRed));
    EXPECT_EQ(left.at(145, 55), rgb(kGreen));
    EXPECT_EQ(left.at(55, 145), rgb(kBlue));
    EXPECT_EQ(left.at(145, 145), rgb(kWhite));
    shown.pose.orientation = turned(180 * kDegree, {0, 1, 0});
    expectCovered(seen(shown)[0], kBlack, [](int, int) { return false; });
    shown.pose = {turned(180 * kDegree, {0, 1, 0}), {0, 0, 2}};  // behind the head, facing it
    expectCovered(seen(shown)[0], kBlack, [](int, int) { return false; });
}

TEST_F(Composition, LayersArePaintedInSubmissionOrder) {
    begin();
    const auto near = quad(solid(kGreen), {0, 0, -1}, {1, 1}), far = quad(solid(kRed), {0, 0, -2}, {0.4F, 4});
    EXPECT_EQ(seen(near, far)[0].at(100, 100), rgb(kRed));
    EXPECT_EQ(seen(far, near)[0].at(100, 100), rgb(kGreen));
    EXPECT_EQ(seen(far, near)[0].at(100, 10), rgb(kRed));
}

TEST_F(Composition, AnEyeSeesItsLayers) {
    begin();
    XrCompositionLayerQuad left = quad(solid(kGreen), {0, 0, -2}, {1, 1});
    XrCompositionLayerQuad right = quad(solid(kBlue), {0, 0, -2}, {1, 1});
    left.eyeVisibility = XR_EYE_VISIBILITY_LEFT;
    right.eyeVisibility = XR_EYE_VISIBILITY_RIGHT;
    const auto eyes = seen(left, right);
    EXPECT_EQ(eyes[0].at(100, 100), rgb(kGreen));
    EXPECT_EQ(eyes[1].at(100, 100), rgb(kBlue));
}

TEST_F(Composition, AlphaIsBlendedInLinearLight) {
    begin();
    const Rgba below{40, 120, 200, 255}, above{200, 90, 30, 128};
    const auto under = quad(solid(below), {0, 0, -2}, {4, 4});
    XrCompositionLayerQuad over = quad(solid(above), {0, 0, -2}, {4, 4});
    const auto expected = [&](double colour_factor, double alpha) {
        Rgb result;
        for (std::size_t k = 0; k < 3; ++k) {
            const double linear = linearFromSrgb(above[k] / 255.0) * colour_factor +
                                  linearFromSrgb(below[k] / 255.0) * (1 - alpha);
            result[k] = static_cast<std::uint8_t>(std::lround(255 * srgbFromLinear(std::min(linear, 1.0))));
        }
        return result;
    };
    constexpr double kAlpha = 128 / 255.0;
    expectNear(seen(under, over)[0].at(100, 100), rgb(above));
    over.layerFlags = XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;  // blending is off: opaque
    expectNear(seen(under, over)[0].at(100, 100), rgb(above));
    over.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    expectNear(seen(under, over)[0].at(100, 100), expected(1, kAlpha));
    over.layerFlags |= XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    expectNear(seen(under, over)[0].at(100, 100), expected(kAlpha, kAlpha));
    over.layerFlags |= XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT;
    expectNear(seen(under, over)[0].at(100, 100), expected(kAlpha, kAlpha));
}

TEST_F(Composition, ALinearFormatHoldsLinearLight) {
    begin();
    const Swapchain linear = picture(4, 4, std::vector(16, Rgba{0, 128, 255, 255}), VK_FORMAT_R8G8B8A8_UNORM);
    expectNear(seen(quad(linear, {0, 0, -2}, {1, 1}))[0].at(100, 100), {0, 188, 255});
}

TEST_F(Composition, NothingBleedsInFromOutsideTheSubImageOrItsSlice) {
    begin();
    std::vector<Rgba> texels(2 * 16 * 16, kRed);
    for (std::size_t y = 5; y < 9; ++y)
        for (std::size_t x = 3; x < 10; ++x)
            texels[256 + y * 16 + x] = kGreen;
    XrCompositionLayerQuad shown = quad(picture(16, 16, texels), {0.11F, 0.19F, -2}, {1, 0.5F});
    shown.subImage.imageArrayIndex = 1;
    shown.subImage.imageRect = {{3, 5}, {7, 4}};
    const int covered = expectCovered(seen(shown)[0], rgb(kGreen),
                                      [](int x, int y) { return x >= 82 && x < 132 && y >= 78 && y < 103; });
    EXPECT_EQ(covered, 50 * 25);
    shown.subImage.imageRect.extent = {0, 4};
    expectCovered(seen(shown)[0], kBlack, [](int, int) { return false; });
}

TEST_F(Composition, AnInfiniteCylinderDependsOnDirectionOnly) {
    begin();
    for (const float radius : {0.0F, std::numeric_limits<float>::infinity()}) {
        for (const Picture& eye : seen(cylinder(solid(kGreen), radius, 60 * kDegree, 2))) {
            const int covered = expectCovered(eye, rgb(kGreen), [](int x, int y) {
                const double angle = std::atan(across(x));
                const double height = up(y) * std::cos(angle);  // at a distance of 1 from the axis
                return std::abs(angle) <= 30 * kDegree && std::abs(height) <= 30 * kDegree / 2;
            });
            EXPECT_GT(covered, 100 * 50);
        }
    }
}

TEST_F(Composition, ACylinderHasItsAngleRadiusAndTexture) {
    begin();
    const Swapchain thirds = picture(3, 1, {kRed, kGreen, kBlue});
    const auto layer = cylinder(thirds, 0.5F, 80 * kDegree, 1.5F);
    const auto eyes = seen(layer);
    for (int eye = 0; eye < 2; ++eye) {
        const double eye_x = eye == 0 ? -0.03 : 0.03;
        const Picture& picture = eyes[static_cast<std::size_t>(eye)];
        for (int x = 0; x < kSize; ++x) {
            // Solve |eye + t (tan, -1)| = 0.5 for the larger t: the cylinder is seen from inside.
            const double a = 1 + across(x) * across(x), b = eye_x * across(x);
            const double t = (-b + std::sqrt(b * b - a * (eye_x * eye_x - 0.25))) / a;
            const double angle = std::atan2(eye_x + t * across(x), t),
                         third = (angle / kDegree + 40) / 80 * 3;
            const Rgb shown = picture.at(x, 100);
            if (third < 0 || third > 3) {
                EXPECT_EQ(shown, kBlack) << x;
            } else if (std::abs(third - std::floor(third) - 0.5) < 0.01) {
                EXPECT_GT(shown[static_cast<std::size_t>(third)], 240) << x;  // centre of a texel
            }
            // Height 0.5 * angle / 1.5, half of it above and half below the centre.
            const double edge = 0.5 * 80 * kDegree / 1.5 / 2 / t;  // tangent
            const int top = static_cast<int>(std::floor(100 - 100 * edge));
            if (third > 0 && third < 3 && top > 2) {
                EXPECT_EQ(picture.at(x, top - 1), kBlack) << x;
                EXPECT_NE(picture.at(x, top + 1), kBlack) << x;
            }
        }
    }
}

TEST_F(Composition, ACylinderIsVisibleOnlyFromInside) {
    begin();
    auto layer = cylinder(solid(kBlue), 1, 90 * kDegree, 1);
    layer.pose.position = {0, 0, -5};
    EXPECT_EQ(seen(layer)[0].at(100, 100), rgb(kBlue));  // its far side, through the open near side
    layer.pose.orientation = turned(180 * kDegree, {0, 1, 0});
    expectCovered(seen(layer)[0], kBlack, [](int, int) { return false; });
    layer.centralAngle = 0;
    expectCovered(seen(layer)[0], kBlack, [](int, int) { return false; });
}

// Texels in which each 8-bit value has many different neighbours. Alpha is random and must have no effect.
std::vector<Rgba> noise(std::size_t count) {
    std::vector<Rgba> texels(count);
    std::uint32_t state = 1;
    for (Rgba& texel : texels) {
        for (std::uint8_t& channel : texel) {
            state = state * 1664525 + 1013904223;
            channel = static_cast<std::uint8_t>(state >> 24);
        }
    }
    return texels;
}

TEST_F(Composition, ALayerSubmittedAsTheEyeSeesItIsReproducedExactly) {
    begin(R"(, "controllers": {})");
    const std::vector<Rgba> texels = noise(2 * 320 * 240);
    const Swapchain swapchain = picture(320, 240, texels);
    for (const auto type : {XR_REFERENCE_SPACE_TYPE_LOCAL, XR_REFERENCE_SPACE_TYPE_STAGE}) {
        const XrSpace space = createSpace(type, {turned(1, {0, 0.6F, 0.8F}), {1, -2, 3}});
        auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
        ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
        ASSERT_EQ(beginFrame(), XR_SUCCESS);
        const auto eyes = locateViews(space, state.predictedDisplayTime);
        std::array<XrCompositionLayerProjectionView, 2> views{};
        for (std::uint32_t i = 0; i < 2; ++i)
            views[i] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, eyes[i].pose, eyes[i].fov,
                        whole(swapchain, i)};
        const XrCompositionLayerProjection layer{
            XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, space, 2, views.data()};
        label("capture:same");
        ASSERT_EQ(endFrame(state.predictedDisplayTime, {header(layer)}), XR_SUCCESS);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            Picture submitted{320, 240, {}};
            for (std::size_t i = 0; i < 320 * 240; ++i)
                submitted.pixels.push_back(rgb(texels[eye * 320 * 240 + i]));
            const Picture shown = readPicture(file(eye == 0 ? "same_left.png" : "same_right.png"));
            EXPECT_EQ(compare(shown, submitted).largest, 0) << "eye " << eye;
        }
    }
}

TEST_F(Composition, AProjectionLayerIsReprojectedByRotationOnly) {
    begin();
    std::vector<Rgba> halves;
    for (int i = 0; i < kSize * kSize; ++i)
        halves.push_back(i % kSize < 100 ? kRed : kGreen);
    const Swapchain swapchain = picture(kSize, kSize, halves);
    constexpr auto kSide = static_cast<float>(std::numbers::pi / 4);
    const XrPosef submitted{turned(10 * kDegree, {0, 1, 0}), {0.5F, 0.2F, -1}};  // to the left
    std::array<XrCompositionLayerProjectionView, 2> views;
    views.fill({XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                nullptr,
                submitted,
                {-kSide, kSide, kSide, -kSide},
                whole(swapchain)});
    const XrCompositionLayerProjection layer{
        XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, view_, 2, views.data()};
    for (const Picture& eye : seen(layer)) {
        // The layer's centre is 10 degrees to the left, its right end 35 degrees to the right.
        const int middle = static_cast<int>(100 - 100 * std::tan(10 * kDegree));
        const int end = static_cast<int>(100 + 100 * std::tan(35 * kDegree));
        EXPECT_EQ(eye.at(middle - 2, 100), rgb(kRed));
        EXPECT_EQ(eye.at(middle + 2, 100), rgb(kGreen));
        EXPECT_EQ(eye.at(end - 1, 100), rgb(kGreen));
        EXPECT_EQ(eye.at(end + 1, 100), kBlack);
    }
}

TEST_F(Composition, ALayerFollowsAHandAndDisappearsWithIt) {
    begin(R"(, "controllers": { "left": { "poses": [ { "t_s": 0, "position": [0.3, 1.6, -2.2] } ] } })");
    auto set_info = makeStruct<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::snprintf(set_info.actionSetName, sizeof set_info.actionSetName, "hands");
    std::snprintf(set_info.localizedActionSetName, sizeof set_info.localizedActionSetName, "Hands");
    XrActionSet set = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateActionSet(instance_, &set_info, &set), XR_SUCCESS);
    auto action_info = makeStruct<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    action_info.actionType = XR_ACTION_TYPE_POSE_INPUT;
    std::snprintf(action_info.actionName, sizeof action_info.actionName, "grip");
    std::snprintf(action_info.localizedActionName, sizeof action_info.localizedActionName, "Grip");
    XrAction grip = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateAction(set, &action_info, &grip), XR_SUCCESS);
    const XrActionSuggestedBinding binding{grip, path("/user/hand/left/input/grip/pose")};
    const XrInteractionProfileSuggestedBinding bindings{
        XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
        path("/interaction_profiles/khr/simple_controller"), 1, &binding};
    ASSERT_EQ(xrSuggestInteractionProfileBindings(instance_, &bindings), XR_SUCCESS);
    const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set};
    ASSERT_EQ(xrAttachSessionActionSets(session_, &attach), XR_SUCCESS);
    const XrActionSpaceCreateInfo space_info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, grip, XR_NULL_PATH,
                                             kIdentity};
    XrSpace hand = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateActionSpace(session_, &space_info, &hand), XR_SUCCESS);

    XrCompositionLayerQuad shown = quad(solid(kRed), {0, 0, 0}, {1, 1});
    shown.space = hand;
    const Picture before = seen(shown)[0];  // before the first xrSyncActions: no hand, so no quad
    expectCovered(before, kBlack, [](int, int) { return false; });
    const XrActiveActionSet active{set, XR_NULL_PATH};
    const XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
    ASSERT_EQ(xrSyncActions(session_, &sync), XR_SUCCESS);
    // A quad at the same place in STAGE.
    XrCompositionLayerQuad fixed = shown;
    fixed.space = stage_;
    fixed.pose.position = {0.3F, 1.6F, -2.2F};
    const Picture in_hand = seen(shown)[0];
    EXPECT_EQ(in_hand.pixels, seen(fixed)[0].pixels);
}

TEST_F(Composition, ADroppedFrameIsNotShown) {
    begin(R"(, "events": [ { "frame": 5, "frames": { "dropped": true } } ])");
    const auto red = quad(solid(kRed), {0, 0, -2}, {1, 1}), green = quad(solid(kGreen), {0, 0, -2}, {1, 1});
    frame();  // frame 4
    EXPECT_TRUE(seen(red)[0].pixels.empty());
    frame({header(green)});
    EXPECT_EQ(readPicture(file("seen_left.png")).at(100, 100), rgb(kGreen));
}

TEST_F(Composition, LeavesTheSwapchainImagesUnchanged) {
    begin();
    const std::vector<Rgba> texels = noise(64 * 48);
    const Swapchain swapchain = picture(64, 48, texels);
    seen(quad(swapchain, {0, 0, -2}, {1, 1}));
    EXPECT_EQ(readTexels(swapchain, swapchain.images[0], 1), texels);
}

TEST_F(Composition, AgreesWithADoublePrecisionReference) {
    begin();
    const std::vector<Rgba> room = pattern(256, 256, 8), note = pattern(192, 128, 6),
                            wide = pattern(400, 100, 10);
    const XrPosef submitted{turned(0.1, {0.6F, 0.8F, 0}), {0, 0, 0}};
    const XrFovf fov{-0.9F, 0.8F, 0.75F, -0.85F};
    const Swapchain room_picture = picture(256, 256, room);
    std::array<XrCompositionLayerProjectionView, 2> views;
    views.fill({XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, submitted, fov, whole(room_picture)});
    const XrCompositionLayerProjection projection{
        XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, view_, 2, views.data()};
    auto screen = cylinder(picture(400, 100, wide), 1.5F, 100 * kDegree, 4);
    screen.pose = {turned(0.2, {1, 0, 0}), {0, 0.5F, 0}};
    screen.layerFlags =
        XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT | XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    const Swapchain note_picture = picture(192, 128, note);
    auto near = quad(note_picture, {-0.3F, -0.2F, -1}, {0.9F, 0.6F});
    near.pose.orientation = turned(0.7, {0, 1, 0});
    auto small = quad(note_picture, {0.5F, -0.4F, -1.5F}, {0.45F, 0.3F});
    small.layerFlags = screen.layerFlags;
    const auto eyes = seen(projection, screen, near, small);

    const auto reference = [&](float eye_x) {
        ReferenceLayer a{
            XR_TYPE_COMPOSITION_LAYER_PROJECTION, submitted, fov, {}, 0, 0, 0, 0, room, 256, 256};
        a.stage_from_layer.position = {eye_x, 0, 0};  // only its direction matters
        ReferenceLayer b{XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR,
                         screen.pose,
                         {},
                         {},
                         screen.radius,
                         screen.centralAngle,
                         screen.aspectRatio,
                         screen.layerFlags,
                         wide,
                         400,
                         100};
        ReferenceLayer c{
            XR_TYPE_COMPOSITION_LAYER_QUAD, near.pose, {}, near.size, 0, 0, 0, 0, note, 192, 128};
        ReferenceLayer d{XR_TYPE_COMPOSITION_LAYER_QUAD,
                         small.pose,
                         {},
                         small.size,
                         0,
                         0,
                         0,
                         small.layerFlags,
                         note,
                         192,
                         128};
        constexpr auto kSide = static_cast<float>(std::numbers::pi / 4);
        return composeReference({a, b, c, d}, {{0, 0, 0, 1}, {eye_x, 0, 0}}, {-kSide, kSide, kSide, -kSide},
                                eyes[0].width, eyes[0].height);
    };
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const Difference off = compare(eyes[eye], reference(eye == 0 ? -0.03F : 0.03F));
        RecordProperty(eye == 0 ? "left_psnr_db" : "right_psnr_db", std::to_string(off.psnr_db));
        // At an edge, single precision may move a ray to the other side.
        EXPECT_LT(off.share_over_one, 2e-4) << "eye " << eye;
        EXPECT_GT(off.psnr_db, 55) << "eye " << eye;
    }
}

}  // namespace
}  // namespace mock_test
