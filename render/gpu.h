// The Vulkan instance, device and queue. An OpenXR runtime may insist on making them: hence the hooks.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <vulkan/vulkan_raii.hpp>

namespace stylet::render {

// A Vulkan call failed: what() names the call and the result.
class GpuError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// Each may be empty: then Vulkan is called directly and the first device that fits is taken.
struct GpuHooks {
    std::function<VkResult(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*)>
        createInstance;
    std::function<VkPhysicalDevice(VkInstance)> pickDevice;
    std::function<VkResult(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*, VkDevice*)>
        createDevice;
};

// How both eyes are drawn. `best`: one pass where the driver really does it, found by drawing a pixel.
enum class StereoPath : std::uint8_t {
    best,
    multiview,  // one draw, gl_ViewIndex
    layered,    // one instanced draw, gl_Layer = gl_InstanceIndex
    single      // one eye after the other
};

struct GpuSettings {
    bool validation = false;  // VK_LAYER_KHRONOS_validation with synchronisation checks; messages are counted
    std::string pipeline_cache = {};       // file, empty = none; read at start, written at the end
    StereoPath stereo = StereoPath::best;  // anything else: that path or GpuError
    // Vulkan extensions beside its own, without which there is no device: a window's.
    std::vector<const char*> instance_extensions = {}, device_extensions = {};
};

// Pipelines so far.
struct PipelineWork {
    std::uint64_t made = 0;
    double made_ms = 0.0;
    std::size_t kept_bytes = 0;  // what the driver was given of an earlier program's
};

// Move-only owner; members die in reverse order.
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
    bool isProcessor() const;                  // Vulkan in software
    std::string name() const;                  // "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::uint64_t validationMessages() const;  // warnings and errors so far, 0 without validation
    // Every pipeline is made here, through the cache, and counted.
    vk::raii::Pipeline pipeline(const vk::GraphicsPipelineCreateInfo&) const;
    vk::raii::Pipeline pipeline(const vk::ComputePipelineCreateInfo&) const;
    PipelineWork pipelineWork() const;
    // True when multiview with two views really renders to both layers (tested with one pixel, not by the
    // flag).
    bool multiviewWorks() const;
    StereoPath stereoPath() const;  // never `best`

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
