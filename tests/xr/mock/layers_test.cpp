#include <limits>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Layers of the cylinder and depth extensions. swapchain_test.cpp covers the core layers.
class ExtensionLayers : public MockTest {
  protected:
    void begin() {
        startFocused();
        swapchain_ = createSwapchain(swapchainInfo());
        cycle(swapchain_.handle);
        XrSwapchainCreateInfo info = swapchainInfo();
        info.format = VK_FORMAT_D16_UNORM;
        info.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
        depth_ = createSwapchain(info);
        cycle(depth_.handle);
    }
    XrResult submit(const void* layer) {
        return tryFrame({static_cast<const XrCompositionLayerBaseHeader*>(layer)});
    }
    XrCompositionLayerCylinderKHR cylinder() const {
        return {XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR,
                nullptr,
                0,
                stage_,
                XR_EYE_VISIBILITY_BOTH,
                whole(swapchain_),
                kIdentity,
                1,
                1,
                1};
    }
    XrResult submitWith(float radius, float angle, float aspect) {
        auto layer = cylinder();
        layer.radius = radius;
        layer.centralAngle = angle;
        layer.aspectRatio = aspect;
        return submit(&layer);
    }
    XrResult submitDepth(XrCompositionLayerDepthInfoKHR depth) {
        const XrCompositionLayerProjectionView view{
            XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, &depth, kIdentity, {-1, 1, 1, -1}, whole(swapchain_)};
        const std::array views{view, view};
        const XrCompositionLayerProjection layer{
            XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, stage_, 2, views.data()};
        return submit(&layer);
    }

    Swapchain swapchain_, depth_;
};

TEST_F(ExtensionLayers, CylindersAreChecked) {
    begin();
    for (const float radius : {0.0F, 1.0F, kInfinity})
        EXPECT_EQ(submitWith(radius, 1, 1), XR_SUCCESS);
    EXPECT_EQ(submitWith(1, 0, 1), XR_SUCCESS);
    for (const float radius : {-1.0F, -kInfinity, kNan})
        EXPECT_EQ(submitWith(radius, 1, 1), XR_ERROR_VALIDATION_FAILURE);
    for (const float angle : {-0.1F, 6.2831855F, kNan})
        EXPECT_EQ(submitWith(1, angle, 1), XR_ERROR_VALIDATION_FAILURE);
    for (const float aspect : {0.0F, -1.0F, kInfinity, kNan})
        EXPECT_EQ(submitWith(1, 1, aspect), XR_ERROR_VALIDATION_FAILURE);
    auto layer = cylinder();
    layer.pose.orientation = {0, 0, 0, 0.98F};
    EXPECT_EQ(submit(&layer), XR_ERROR_POSE_INVALID);
    layer = cylinder();
    layer.subImage.imageRect.offset.x = 1;
    EXPECT_EQ(submit(&layer), XR_ERROR_SWAPCHAIN_RECT_INVALID);
    layer = cylinder();
    layer.subImage.imageArrayIndex = 2;
    EXPECT_EQ(submit(&layer), XR_ERROR_VALIDATION_FAILURE);
    layer = cylinder();
    layer.eyeVisibility = XR_EYE_VISIBILITY_MAX_ENUM;
    EXPECT_EQ(submit(&layer), XR_ERROR_VALIDATION_FAILURE);
    layer = cylinder();
    layer.layerFlags = 0x100;
    EXPECT_EQ(submit(&layer), XR_ERROR_VALIDATION_FAILURE);
    layer = cylinder();
    layer.subImage.swapchain = createSwapchain(swapchainInfo()).handle;  // no image was released
    EXPECT_EQ(submit(&layer), XR_ERROR_LAYER_INVALID);
}

TEST_F(ExtensionLayers, NeedTheirExtension) {
    extensions_ = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
    begin();
    const auto layer = cylinder();
    EXPECT_EQ(submit(&layer), XR_ERROR_LAYER_INVALID);
    // Without the extension the runtime ignores the structure.
    EXPECT_EQ(submitDepth({XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR, nullptr, {}, 3, 2, 1, 1}), XR_SUCCESS);
}

TEST_F(ExtensionLayers, DepthIsChecked) {
    begin();
    XrCompositionLayerDepthInfoKHR depth{
        XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR, nullptr, whole(depth_), 0, 1, 0.1F, 100};
    const XrCompositionLayerDepthInfoKHR good = depth;
    EXPECT_EQ(submitDepth(depth), XR_SUCCESS);
    for (const auto& [near_z, far_z] : {std::pair{100.0F, 0.1F}, {0.1F, kInfinity}, {kInfinity, 0.0F}}) {
        depth.nearZ = near_z;
        depth.farZ = far_z;
        EXPECT_EQ(submitDepth(depth), XR_SUCCESS);
    }
    for (const auto& [near_z, far_z] :
         {std::pair{1.0F, 1.0F}, {kInfinity, kInfinity}, {-1.0F, 1.0F}, {kNan, 1.0F}}) {
        depth.nearZ = near_z;
        depth.farZ = far_z;
        EXPECT_EQ(submitDepth(depth), XR_ERROR_VALIDATION_FAILURE);
    }
    depth = good;
    for (const auto& [least, most] :
         {std::pair{0.5F, 0.5F}, {0.6F, 0.5F}, {-0.1F, 1.0F}, {0.0F, 1.1F}, {kNan, 1.0F}}) {
        depth.minDepth = least;
        depth.maxDepth = most;
        EXPECT_EQ(submitDepth(depth), XR_ERROR_VALIDATION_FAILURE);
    }
    depth = good;
    depth.subImage.imageRect.extent.height = 49;
    EXPECT_EQ(submitDepth(depth), XR_ERROR_SWAPCHAIN_RECT_INVALID);
    depth = good;
    depth.subImage.swapchain = XR_NULL_HANDLE;
    EXPECT_EQ(submitDepth(depth), XR_ERROR_HANDLE_INVALID);
}

}  // namespace
}  // namespace mock_test
