// A Vulkan layer between the loader and the real driver that makes a device fail on purpose. It reads these
// environment variables when an instance is created:
//   STYLET_FAULT_LOST_AFTER   number of submissions that succeed; later ones return VK_ERROR_DEVICE_LOST
//   STYLET_FAULT_MEMORY       bytes; a larger allocation returns VK_ERROR_OUT_OF_DEVICE_MEMORY
//   STYLET_FAULT_IMAGE_3D     upper limit of the reported maxImageDimension3D
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>

namespace {

struct Faults {
    std::int64_t lost_after = -1;
    std::uint64_t memory = UINT64_MAX;
    std::uint32_t image_3d = UINT32_MAX;
};

// Functions of the next layer or driver in the chain. They are looked up when the instance or device is
// created, because a later look-up through the loader would return this layer's own functions.
struct Next {
    PFN_vkGetInstanceProcAddr instance_proc = nullptr;
    PFN_vkGetDeviceProcAddr device_proc = nullptr;
    VkInstance instance = VK_NULL_HANDLE;
    PFN_vkGetPhysicalDeviceProperties properties = nullptr;
    PFN_vkGetPhysicalDeviceProperties2 properties2 = nullptr;
    PFN_vkAllocateMemory allocate = nullptr;
    PFN_vkQueueSubmit2 submit = nullptr;
};

std::mutex guard;
Faults faults;
std::atomic<std::int64_t> submitted{0};
std::map<void*, Next> instances, devices;

void* dispatchKey(const void* handle) {
    void* table = nullptr;
    std::memcpy(&table, handle, sizeof table);
    return table;
}

std::uint64_t number(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

Next findNext(const std::map<void*, Next>& known, const void* handle) {
    const std::lock_guard lock(guard);
    return known.at(dispatchKey(handle));
}

template <typename Info, typename Link>
Link* findLink(const Info* info, VkStructureType type) {
    auto* link = static_cast<Link*>(const_cast<void*>(info->pNext));
    while (link && !(link->sType == type && link->function == VK_LAYER_LINK_INFO))
        link = static_cast<Link*>(const_cast<void*>(link->pNext));
    return link;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info,
                                              const VkAllocationCallbacks* memory, VkInstance* out) {
    auto* link = findLink<VkInstanceCreateInfo, VkLayerInstanceCreateInfo>(
        info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(next(VK_NULL_HANDLE, "vkCreateInstance"));
    const VkResult result = create(info, memory, out);
    if (result != VK_SUCCESS) return result;
    const std::lock_guard lock(guard);
    const auto find = [&](const char* name) { return next(*out, name); };
    instances[dispatchKey(*out)] = {
        .instance_proc = next,
        .instance = *out,
        .properties =
            reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(find("vkGetPhysicalDeviceProperties")),
        .properties2 =
            reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(find("vkGetPhysicalDeviceProperties2"))};
    faults = {static_cast<std::int64_t>(number("STYLET_FAULT_LOST_AFTER", UINT64_MAX)),
              number("STYLET_FAULT_MEMORY", UINT64_MAX),
              static_cast<std::uint32_t>(number("STYLET_FAULT_IMAGE_3D", UINT32_MAX))};
    submitted = 0;
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice gpu, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* memory, VkDevice* out) {
    auto* link = findLink<VkDeviceCreateInfo, VkLayerDeviceCreateInfo>(
        info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    const PFN_vkGetDeviceProcAddr next_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const VkInstance instance = findNext(instances, gpu).instance;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(next(instance, "vkCreateDevice"));
    const VkResult result = create(gpu, info, memory, out);
    if (result != VK_SUCCESS) return result;
    const std::lock_guard lock(guard);
    devices[dispatchKey(*out)] = {
        .instance_proc = next,
        .device_proc = next_device,
        .instance = instance,
        .allocate = reinterpret_cast<PFN_vkAllocateMemory>(next_device(*out, "vkAllocateMemory")),
        .submit = reinterpret_cast<PFN_vkQueueSubmit2>(next_device(*out, "vkQueueSubmit2"))};
    return result;
}

void limit(VkPhysicalDeviceProperties& properties) {
    std::uint32_t& most = properties.limits.maxImageDimension3D;
    most = std::min(most, faults.image_3d);
}

VKAPI_ATTR void VKAPI_CALL getProperties(VkPhysicalDevice gpu, VkPhysicalDeviceProperties* out) {
    findNext(instances, gpu).properties(gpu, out);
    limit(*out);
}

VKAPI_ATTR void VKAPI_CALL getProperties2(VkPhysicalDevice gpu, VkPhysicalDeviceProperties2* out) {
    findNext(instances, gpu).properties2(gpu, out);
    limit(out->properties);
}

VKAPI_ATTR VkResult VKAPI_CALL allocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                              const VkAllocationCallbacks* memory, VkDeviceMemory* out) {
    if (info->allocationSize > faults.memory) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return findNext(devices, device).allocate(device, info, memory, out);
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit2(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* infos,
                                            VkFence fence) {
    const std::int64_t before = submitted++;
    if (faults.lost_after >= 0 && before >= faults.lost_after) return VK_ERROR_DEVICE_LOST;
    return findNext(devices, queue).submit(queue, count, infos, fence);
}

PFN_vkVoidFunction own(const char* name);

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL deviceProc(VkDevice device, const char* name) {
    if (const PFN_vkVoidFunction mine = own(name)) return mine;
    const std::lock_guard lock(guard);
    const auto found = devices.find(dispatchKey(device));
    return found == devices.end() ? nullptr : found->second.device_proc(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instanceProc(VkInstance instance, const char* name) {
    if (const PFN_vkVoidFunction mine = own(name)) return mine;
    if (!instance) return nullptr;
    const std::lock_guard lock(guard);
    const auto found = instances.find(dispatchKey(instance));
    return found == instances.end() ? nullptr : found->second.instance_proc(instance, name);
}

PFN_vkVoidFunction own(const char* name) {
    const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
    if (is("vkGetInstanceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(instanceProc);
    if (is("vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(deviceProc);
    if (is("vkCreateInstance")) return reinterpret_cast<PFN_vkVoidFunction>(createInstance);
    if (is("vkCreateDevice")) return reinterpret_cast<PFN_vkVoidFunction>(createDevice);
    if (is("vkGetPhysicalDeviceProperties")) return reinterpret_cast<PFN_vkVoidFunction>(getProperties);
    if (is("vkGetPhysicalDeviceProperties2")) return reinterpret_cast<PFN_vkVoidFunction>(getProperties2);
    if (is("vkAllocateMemory")) return reinterpret_cast<PFN_vkVoidFunction>(allocateMemory);
    if (is("vkQueueSubmit2")) return reinterpret_cast<PFN_vkVoidFunction>(queueSubmit2);
    return nullptr;
}

}  // namespace

extern "C" VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = instanceProc;
    version->pfnGetDeviceProcAddr = deviceProc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
