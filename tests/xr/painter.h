// A Vulkan device made through a session, and one that paints each eye of its images in a plain colour.
#pragma once

#include <array>
#include <map>

#include <vulkan/vulkan_raii.hpp>

#include "xr/xr.h"

namespace stylet::xr {

class Painter {
  public:
    explicit Painter(Session&);
    // Must be called once, before paint(). The session must be gone before the painter is.
    void start();
    void paint(VkImage, const std::array<std::array<float, 4>, 2>& linear_colours);

  private:
    Session& session_;
    vk::raii::Context context_;
    vk::raii::Instance instance_;
    vk::raii::PhysicalDevice gpu_;
    vk::raii::Device device_;
    vk::raii::Queue queue_;
    vk::raii::CommandPool pool_;
    vk::raii::CommandBuffer commands_;
    std::map<VkImage, std::vector<vk::raii::ImageView>> eyes_;
};

}  // namespace stylet::xr
