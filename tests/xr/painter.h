// A Vulkan device created through a session, with a painter that fills the session's images with plain
// colours.
#pragma once

#include <array>
#include <map>
#include <utility>

#include <vulkan/vulkan_raii.hpp>

#include "xr/xr.h"

namespace stylet::xr {

class Painter {
  public:
    explicit Painter(Session&);
    // Call start() once before paint(). The session must be destroyed before the painter.
    void start();
    void paint(VkImage, const std::array<std::array<float, 4>, 2>& linear_colours);
    void paintPanel(VkImage, std::uint32_t width, std::uint32_t height, const std::array<float, 4>&);
    void clearDepth(VkImage, float depth);  // of both eyes

  private:
    struct Area {
        VkImage image;
        vk::Format format;
        vk::ImageAspectFlags aspect;
        std::uint32_t layer, width, height;
    };
    void clear(const Area&, const vk::ClearValue&);
    void submit();

    Session& session_;
    vk::raii::Context context_;
    vk::raii::Instance instance_;
    vk::raii::PhysicalDevice gpu_;
    vk::raii::Device device_;
    vk::raii::Queue queue_;
    vk::raii::CommandPool pool_;
    vk::raii::CommandBuffer commands_;
    std::map<std::pair<VkImage, std::uint32_t>, vk::raii::ImageView> views_;  // by image and layer
};

}  // namespace stylet::xr
