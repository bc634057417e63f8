// The Vulkan instance, device and queue. The hooks let an OpenXR runtime create them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <vulkan/vulkan_raii.hpp>

#include "base/errors.h"

namespace stylet::render {

// A Vulkan call failed. what() names the call and the result.
class GpuError : public EnvironmentError {
  public:
    using EnvironmentError::EnvironmentError;
};

// Each hook may be empty. Then Vulkan is called directly, and the best capable device is used (discrete
// GPUs first).
struct GpuHooks {
    std::function<VkResult(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*)>
        createInstance;
    std::function<VkPhysicalDevice(VkInstance)> pickDevice;
    std::function<VkResult(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*, VkDevice*)>
        createDevice;
};

// How both eyes are drawn. `best`: the first that works of multiview, layered and single. Multiview is
// tested by drawing a pixel.
enum class StereoPath : std::uint8_t {
    best,
    multiview,  // one draw, gl_ViewIndex
    layered,    // one instanced draw, gl_Layer = gl_InstanceIndex
    single      // one eye after the other
};

struct GpuSettings {
    bool validation = false;  // VK_LAYER_KHRONOS_validation with synchronisation checks; messages are counted
    std::string pipeline_cache = {};       // file, empty = none; read at start, written at the end
    StereoPath stereo = StereoPath::best;  // any other value: that path, or GpuError if it does not work
    // Additional Vulkan extensions that are required, for example by a window.
    std::vector<const char*> instance_extensions = {}, device_extensions = {};
};

// Statistics of the pipelines created so far.
struct PipelineWork {
    std::uint64_t made = 0;
    double creation_ms = 0.0;
    std::size_t loaded_bytes = 0;  // bytes of an earlier run's cache, passed to the driver
};

// Move-only owner. Members are destroyed in reverse order of declaration.
class Gpu {
  public:
    explicit Gpu(const GpuSettings&, const GpuHooks& = {});
    ~Gpu();
    Gpu(Gpu&&) noexcept;
    Gpu& operator=(Gpu&&) noexcept;

    const vk::raii::Instance& instance() const;
    const vk::raii::PhysicalDevice& physicalDevice() const;
    const vk::raii::Device& device() const;
    const vk::raii::Queue& queue() const;
    std::uint32_t queueFamily() const;
    bool isSoftware() const;                   // true: Vulkan runs in software
    std::string name() const;                  // "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::uint64_t validationMessages() const;  // warnings and errors so far, 0 without validation
    // Creates a pipeline through the cache and counts it. All pipelines are created here.
    vk::raii::Pipeline pipeline(const vk::GraphicsPipelineCreateInfo&) const;
    vk::raii::Pipeline pipeline(const vk::ComputePipelineCreateInfo&) const;
    PipelineWork pipelineWork() const;
    // True if multiview with two views really renders to both layers. Tested with one pixel; the feature
    // flag is not trusted.
    bool multiviewWorks() const;
    StereoPath stereoPath() const;  // never `best`

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
