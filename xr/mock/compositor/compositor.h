// Paints layers into an image on the application's GPU.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "compositor/gpu_objects.h"

namespace xrmock {

constexpr std::uint32_t kMaxLayers = 16;  // XR_MIN_COMPOSITION_LAYERS_SUPPORTED

enum class LayerType { projection, quad, cylinder };  // same numbers as in compositor.frag

// 8-bit sRGB with alpha; top row first.
struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

// Push constants of compositor.frag, in its layout.
struct PaintConstants {
    std::array<std::array<float, 4>, 3> layer_from_eye;  // rows: rotation, then the eye's position (m)
    std::array<float, 4> eye_tangents;                   // left, right, up, down
    // Projection: tangents as above; quad: width, height; cylinder: see layerShape() in composition.cpp.
    std::array<float, 4> shape;
    std::array<std::int32_t, 4> rect;  // offset and extent of the sub-image, pixels
    std::array<std::int32_t, 2> picture_size;
    std::int32_t array_index;
    std::uint32_t blending;  // kBlendAlpha, kMultiplyAlpha
};
static_assert(sizeof(PaintConstants) == 112);  // every device supports at least 128 bytes

constexpr std::uint32_t kBlendAlpha = 1;     // otherwise the layer is opaque
constexpr std::uint32_t kMultiplyAlpha = 2;  // colours are not premultiplied

// One layer as seen by one eye.
struct Paint {
    LayerType type;
    const SwapchainImages* images;
    std::uint32_t image;
    PaintConstants constants;
};

// Compositor of one session's device. Objects are created on first use; no frame's contents are kept. All
// functions throw Refused if Vulkan fails.
class Compositor {
  public:
    // Paints the layers in order over transparent black, in linear light and 16-bit floating point, and
    // waits for the GPU. Leaves the contents and layout of the swapchain images unchanged.
    Picture paint(VulkanDevice& device, const std::vector<Paint>& layers, VkExtent2D size);

  private:
    struct Targets {
        VkExtent2D size{0, 0};
        DeviceImage linear, encoded;
        ImageView linear_view;
        Framebuffer framebuffer;
        ReadbackBuffer readback;
    };
    void prepare(const VulkanDevice& device);
    void prepareTargets(const VulkanDevice& device, VkExtent2D size);
    VkPipeline pipelineFor(const VulkanDevice& device, LayerType type);
    VkDescriptorSet descriptorSet(const VulkanDevice& device, VkImageView view);
    void drawLayers(const VulkanDevice& device, VkCommandBuffer commands, const std::vector<Paint>& layers,
                    const std::vector<VkDescriptorSet>& sets) const;
    void readBack(const VulkanDevice& device, VkCommandBuffer commands) const;

    DescriptorSetLayout set_layout_;
    DescriptorPool descriptors_;
    PipelineLayout layout_;
    RenderPass pass_;
    std::array<Pipeline, 3> pipelines_;  // by LayerType
    Targets targets_;
};

}  // namespace xrmock
