#include "render/gpu/gpu.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include "base/cache_file.h"
#include "render/gpu/pipeline_cache_file.h"
#include "render/gpu/probe.h"

namespace stylet::render {
namespace {

constexpr char kValidationLayer[] = "VK_LAYER_KHRONOS_validation";
constexpr std::uint64_t kMessagesPrinted = 20;

void check(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw GpuError(fmt::format("{}: {}", call, vk::to_string(vk::Result(result))));
}

VKAPI_ATTR VkBool32 VKAPI_CALL countMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                            VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    auto& count = *static_cast<std::atomic<std::uint64_t>*>(user);
    if (++count <= kMessagesPrinted) std::fprintf(stderr, "vulkan: %s\n", data->pMessage);
    return VK_FALSE;
}

bool hasLayer(const vk::raii::Context& context, const char* name) {
    const auto layers = context.enumerateInstanceLayerProperties();
    return std::any_of(layers.begin(), layers.end(),
                       [&](const vk::LayerProperties& l) { return std::strcmp(l.layerName, name) == 0; });
}

bool hasExtension(const vk::raii::PhysicalDevice& device, const char* name) {
    const auto extensions = device.enumerateDeviceExtensionProperties();
    return std::any_of(extensions.begin(), extensions.end(), [&](const vk::ExtensionProperties& e) {
        return std::strcmp(e.extensionName, name) == 0;
    });
}

struct DeviceFeatures {
    vk::PhysicalDeviceFeatures core;
    vk::PhysicalDeviceVulkan11Features v11;
    vk::PhysicalDeviceVulkan13Features v13;
};

DeviceFeatures queryFeatures(const vk::raii::PhysicalDevice& device) {
    const auto chain = device.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan11Features,
                                           vk::PhysicalDeviceVulkan13Features>();
    return {chain.get<vk::PhysicalDeviceFeatures2>().features,
            chain.get<vk::PhysicalDeviceVulkan11Features>(), chain.get<vk::PhysicalDeviceVulkan13Features>()};
}

bool isCapable(const vk::raii::PhysicalDevice& device) {
    if (device.getProperties().apiVersion < VK_API_VERSION_1_3) return false;
    const DeviceFeatures f = queryFeatures(device);
    return f.v13.dynamicRendering && f.v13.synchronization2 && f.v13.maintenance4 &&
           f.core.fragmentStoresAndAtomics;
}

int rank(const vk::raii::PhysicalDevice& device) {
    constexpr std::array kPreferred{vk::PhysicalDeviceType::eDiscreteGpu,
                                    vk::PhysicalDeviceType::eIntegratedGpu,
                                    vk::PhysicalDeviceType::eVirtualGpu};
    const auto type = device.getProperties().deviceType;
    return int(std::find(kPreferred.begin(), kPreferred.end(), type) - kPreferred.begin());
}

std::uint32_t graphicsFamily(const vk::raii::PhysicalDevice& device) {
    const auto families = device.getQueueFamilyProperties();
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if (families[i].queueFlags & vk::QueueFlagBits::eGraphics) return i;
    throw GpuError(
        "vkGetPhysicalDeviceQueueFamilyProperties: this Vulkan device cannot draw, it has no graphics queue");
}

std::vector<std::uint8_t> readCache(const std::string& file) {
    std::error_code none;
    if (std::filesystem::file_size(file, none) > kMaxCacheBytes || none) return {};
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

struct Gpu::Impl {
    std::atomic<std::uint64_t> messages{0};
    std::string cache_file;
    vk::raii::Context context;
    vk::raii::Instance instance = nullptr;
    vk::raii::DebugUtilsMessengerEXT messenger = nullptr;
    vk::raii::PhysicalDevice physical = nullptr;
    vk::raii::Device device = nullptr;
    vk::raii::Queue queue = nullptr;
    vk::raii::PipelineCache cache = nullptr;
    std::atomic<std::uint64_t> pipelines{0}, pipelines_ns{0};
    std::size_t loaded_bytes = 0;
    std::uint32_t family = 0;
    bool multiview_offered = false, layered_offered = false, multiview_works = false;
    StereoPath stereo = StereoPath::single;

    void makeInstance(const GpuSettings&, const GpuHooks&);
    void pickDevice(const GpuHooks&);
    void makeDevice(const GpuSettings&, const GpuHooks&);
    void makeCache();
    void chooseStereo(StereoPath wanted);
    template <typename Make>
    vk::raii::Pipeline counted(const Make&);
};

void Gpu::Impl::makeInstance(const GpuSettings& settings, const GpuHooks& hooks) {
    const vk::ApplicationInfo application{.pApplicationName = "stylet", .apiVersion = VK_API_VERSION_1_3};
    const vk::DebugUtilsMessengerCreateInfoEXT messages_info{
        .messageSeverity = vk::DebugUtilsMessageSeverityFlagBitsEXT::eWarning |
                           vk::DebugUtilsMessageSeverityFlagBitsEXT::eError,
        .messageType = vk::DebugUtilsMessageTypeFlagBitsEXT::eGeneral |
                       vk::DebugUtilsMessageTypeFlagBitsEXT::eValidation |
                       vk::DebugUtilsMessageTypeFlagBitsEXT::ePerformance,
        .pfnUserCallback = countMessage,
        .pUserData = &messages};
    const vk::ValidationFeatureEnableEXT synchronisation =
        vk::ValidationFeatureEnableEXT::eSynchronizationValidation;
    const vk::ValidationFeaturesEXT checks{.pNext = &messages_info,
                                           .enabledValidationFeatureCount = 1,
                                           .pEnabledValidationFeatures = &synchronisation};
    const char* layer = kValidationLayer;
    std::vector<const char*> extensions = settings.instance_extensions;
    if (settings.validation) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    vk::InstanceCreateInfo info{.pApplicationInfo = &application,
                                .enabledExtensionCount = std::uint32_t(extensions.size()),
                                .ppEnabledExtensionNames = extensions.data()};
    if (settings.validation) {
        if (!hasLayer(context, kValidationLayer))
            throw GpuError(
                fmt::format("{} is not installed (package vulkan-validationlayers)", kValidationLayer));
        info.pNext = &checks;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &layer;
    }
    if (hooks.createInstance) {
        VkInstance made = VK_NULL_HANDLE;
        const VkInstanceCreateInfo& plain = info;
        check(hooks.createInstance(context.getDispatcher()->vkGetInstanceProcAddr, &plain, &made),
              "vkCreateInstance");
        instance = vk::raii::Instance(context, made);
    } else {
        instance = vk::raii::Instance(context, info);
    }
    if (settings.validation) messenger = vk::raii::DebugUtilsMessengerEXT(instance, messages_info);
}

void Gpu::Impl::pickDevice(const GpuHooks& hooks) {
    if (hooks.pickDevice) {
        physical = vk::raii::PhysicalDevice(instance, hooks.pickDevice(*instance));
        if (!isCapable(physical))
            throw GpuError(
                "xrGetVulkanGraphicsDevice2KHR: the OpenXR runtime's graphics device lacks Vulkan 1.3 with "
                "dynamic "
                "rendering. Update the graphics driver.");
        return;
    }
    vk::raii::PhysicalDevices devices(instance);
    const auto better = [](const vk::raii::PhysicalDevice& a, const vk::raii::PhysicalDevice& b) {
        return std::pair(!isCapable(a), rank(a)) < std::pair(!isCapable(b), rank(b));
    };
    const auto found = std::min_element(devices.begin(), devices.end(), better);
    if (found == devices.end() || !isCapable(*found))
        throw GpuError(
            "vkEnumeratePhysicalDevices: no graphics device supports Vulkan 1.3 with dynamic rendering. "
            "Update the "
            "graphics driver, or install Mesa's software driver (mesa-vulkan-drivers).");
    physical = std::move(*found);
}

void Gpu::Impl::makeDevice(const GpuSettings& settings, const GpuHooks& hooks) {
    const DeviceFeatures offered = queryFeatures(physical);
    multiview_offered = offered.v11.multiview;
    // VkPhysicalDeviceVulkan12Features must not be in the chain, so gl_Layer in vertex shaders is enabled
    // through its extension. An OpenXR runtime may append VkPhysicalDeviceTimelineSemaphoreFeatures (Monado
    // does), and Vulkan forbids both in one chain.
    std::vector<const char*> extensions = settings.device_extensions;
    layered_offered = hasExtension(physical, VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME);
    if (layered_offered) extensions.push_back(VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME);
    family = graphicsFamily(physical);
    vk::PhysicalDeviceVulkan11Features v11{.multiview = offered.v11.multiview};
    const vk::PhysicalDeviceVulkan13Features v13{
        .pNext = &v11, .synchronization2 = true, .dynamicRendering = true, .maintenance4 = true};
    const vk::PhysicalDeviceFeatures core{.fragmentStoresAndAtomics = true};
    const float priority = 1.0f;
    const vk::DeviceQueueCreateInfo queue_info{
        .queueFamilyIndex = family, .queueCount = 1, .pQueuePriorities = &priority};
    const vk::DeviceCreateInfo info{.pNext = &v13,
                                    .queueCreateInfoCount = 1,
                                    .pQueueCreateInfos = &queue_info,
                                    .enabledExtensionCount = std::uint32_t(extensions.size()),
                                    .ppEnabledExtensionNames = extensions.data(),
                                    .pEnabledFeatures = &core};
    if (hooks.createDevice) {
        VkDevice made = VK_NULL_HANDLE;
        const VkDeviceCreateInfo& plain = info;
        check(hooks.createDevice(context.getDispatcher()->vkGetInstanceProcAddr, *physical, &plain, &made),
              "vkCreateDevice");
        device = vk::raii::Device(physical, made);
    } else {
        device = vk::raii::Device(physical, info);
    }
    queue = vk::raii::Queue(device, family, 0);
}

void Gpu::Impl::makeCache() {
    const std::filesystem::path file = cache_file;
    if (!file.empty()) removeStaleTemporaryFiles(file.parent_path(), file.filename().string());
    const std::vector<std::uint8_t> stored =
        cache_file.empty() ? std::vector<std::uint8_t>{} : readCache(cache_file);
    const std::span<const std::uint8_t> whole = decodeCacheFile(stored);
    loaded_bytes = whole.size();
    // The driver ignores data that another driver, or another version of it, wrote.
    cache = vk::raii::PipelineCache(
        device, vk::PipelineCacheCreateInfo{.initialDataSize = whole.size(), .pInitialData = whole.data()});
}

template <typename Make>
vk::raii::Pipeline Gpu::Impl::counted(const Make& make) {
    const auto begin = std::chrono::steady_clock::now();
    vk::raii::Pipeline made = make();
    const std::chrono::nanoseconds took = std::chrono::steady_clock::now() - begin;
    pipelines_ns += std::uint64_t(took.count());
    ++pipelines;
    return made;
}

void Gpu::Impl::chooseStereo(StereoPath wanted) {
    if (wanted == StereoPath::best) {
        stereo = multiview_works   ? StereoPath::multiview
                 : layered_offered ? StereoPath::layered
                                   : StereoPath::single;
        return;
    }
    if (wanted == StereoPath::multiview && !multiview_works)
        throw GpuError("multiview does not work with this graphics driver. Use StereoPath::best.");
    if (wanted == StereoPath::layered && !layered_offered)
        throw GpuError(
            "this graphics driver does not offer VK_EXT_shader_viewport_index_layer, which layered drawing "
            "needs. Use StereoPath::best.");
    stereo = wanted;
}

Gpu::Gpu(const GpuSettings& settings, const GpuHooks& hooks) try : impl_(std::make_unique<Impl>()) {
    impl_->cache_file = settings.pipeline_cache;
    impl_->makeInstance(settings, hooks);
    impl_->pickDevice(hooks);
    impl_->makeDevice(settings, hooks);
    impl_->makeCache();
    impl_->multiview_works = impl_->multiview_offered && probeMultiview(*this);
    impl_->chooseStereo(settings.stereo);
} catch (const vk::Error& e) {
    throw GpuError(e.what());
}

Gpu::~Gpu() {
    if (!impl_ || impl_->cache_file.empty() || !*impl_->device) return;
    try {
        const std::vector<std::uint8_t> bytes = encodeCacheFile(impl_->cache.getData());
        if (bytes.size() > kMaxCacheBytes || bytes == readCache(impl_->cache_file)) return;
        writeCacheFile(impl_->cache_file, {std::as_bytes(std::span(bytes))});
    } catch (const std::exception& e) {
        std::fprintf(stderr, "The pipeline cache was not written, so the next start is slower: %s\n",
                     e.what());
    }
}

Gpu::Gpu(Gpu&&) noexcept = default;
Gpu& Gpu::operator=(Gpu&&) noexcept = default;

const vk::raii::Instance& Gpu::instance() const {
    return impl_->instance;
}
const vk::raii::PhysicalDevice& Gpu::physicalDevice() const {
    return impl_->physical;
}
const vk::raii::Device& Gpu::device() const {
    return impl_->device;
}
const vk::raii::Queue& Gpu::queue() const {
    return impl_->queue;
}
vk::raii::Pipeline Gpu::pipeline(const vk::GraphicsPipelineCreateInfo& info) const {
    return impl_->counted([&] { return impl_->device.createGraphicsPipeline(impl_->cache, info); });
}
vk::raii::Pipeline Gpu::pipeline(const vk::ComputePipelineCreateInfo& info) const {
    return impl_->counted([&] { return impl_->device.createComputePipeline(impl_->cache, info); });
}
PipelineWork Gpu::pipelineWork() const {
    return {impl_->pipelines, 1e-6 * double(impl_->pipelines_ns), impl_->loaded_bytes};
}
std::uint32_t Gpu::queueFamily() const {
    return impl_->family;
}
bool Gpu::isSoftware() const {
    return impl_->physical.getProperties().deviceType == vk::PhysicalDeviceType::eCpu;
}
std::string Gpu::name() const {
    return impl_->physical.getProperties().deviceName.data();
}
std::uint64_t Gpu::validationMessages() const {
    return impl_->messages;
}
bool Gpu::multiviewWorks() const {
    return impl_->multiview_works;
}
StereoPath Gpu::stereoPath() const {
    return impl_->stereo;
}

}  // namespace stylet::render
