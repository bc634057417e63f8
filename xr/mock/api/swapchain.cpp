#include <algorithm>
#include <bit>
#include <memory>

#include "api/api.h"
#include "scenario/profiles.h"
#include "world/objects.h"
#include "world/two_call.h"
#include "world/verify.h"

namespace xrmock {

namespace {

constexpr std::uint32_t kImages = 3;
constexpr XrSwapchainCreateFlags kCreateFlags =
    XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT | XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;
constexpr XrSwapchainUsageFlags kUsageFlags =
    XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
    XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT |
    XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
    XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT;

// Vulkan: floor(log2(larger side)) + 1 levels.
std::uint32_t maxMips(std::uint32_t width, std::uint32_t height) {
    std::uint32_t levels = 1;
    for (std::uint32_t side = std::max(width, height); side > 1; side /= 2)
        ++levels;
    return levels;
}

// The device's formats, limited to those listed in the scenario.
std::vector<VkFormat> offeredFormats(const Session& session) {
    std::vector<VkFormat> formats = swapchainFormats(session.device);
    const auto& listed = session.instance.scenario.offers.formats;
    if (listed) {
        std::erase_if(formats, [&](VkFormat format) {
            return std::find(listed->begin(), listed->end(), std::int64_t{format}) == listed->end();
        });
    }
    return formats;
}

void checkSwapchainInfo(const Session& session, const XrSwapchainCreateInfo& info) {
    requireValid((info.createFlags & ~kCreateFlags) == 0 && (info.usageFlags & ~kUsageFlags) == 0,
                 "createFlags or usageFlags has unknown bits");
    requireValid(
        info.width > 0 && info.height > 0 && info.width <= kMaxImageSize && info.height <= kMaxImageSize,
        "the size is zero or beyond the system's maximum");
    requireValid(info.sampleCount > 0 && info.arraySize > 0 && info.mipCount > 0,
                 "sampleCount, arraySize and mipCount must be at least 1");
    requireValid(info.mipCount <= maxMips(info.width, info.height), "more mip levels than the size has");
    requireValid(info.faceCount == 1 || info.faceCount == 6, "faceCount must be 1 or 6");
    const std::vector<VkFormat> formats = offeredFormats(session);
    const bool offered = std::any_of(formats.begin(), formats.end(),
                                     [&](VkFormat format) { return std::int64_t{format} == info.format; });
    require(offered, XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED,
            "xrEnumerateSwapchainFormats does not list the format");
    require((info.createFlags & XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT) == 0, XR_ERROR_FEATURE_UNSUPPORTED,
            "protected content is not offered");
    require(info.faceCount == 1, XR_ERROR_FEATURE_UNSUPPORTED, "cube maps are not offered");
    require(std::has_single_bit(info.sampleCount) && info.sampleCount <= kMaxSampleCount,
            XR_ERROR_FEATURE_UNSUPPORTED, "sampleCount is 1, 2 or 4");
    const bool is_storage = (info.usageFlags & XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT) != 0;
    require(info.sampleCount == 1 || (info.mipCount == 1 && !is_storage), XR_ERROR_FEATURE_UNSUPPORTED,
            "multisampled images have one mip level and no unordered access");
}

}  // namespace

XrResult enumerateSwapchainFormats(Call& call, XrSession handle, std::uint32_t capacity, std::uint32_t* count,
                                   std::int64_t* formats) {
    const Session& session = call.live<Session>(handle);
    return twoCall(capacity, count, formats, offeredFormats(session));
}

XrResult createSwapchain(Call& call, XrSession handle, const XrSwapchainCreateInfo* info, XrSwapchain* out) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_SWAPCHAIN_CREATE_INFO);
    requireValid(out != nullptr, "swapchain is null");
    checkSwapchainInfo(session, *info);
    const bool is_static = (info->createFlags & XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT) != 0;
    const std::uint32_t count = is_static ? 1 : kImages;
    auto swapchain = std::make_unique<Swapchain>(session, *info, count);
    swapchain->is_static = is_static;
    for (std::uint32_t i = 0; i < count; ++i)
        swapchain->free_images.push_back(i);
    *out = toHandle<XrSwapchain>(call.create(std::move(swapchain), &session));
    return XR_SUCCESS;
}

XrResult enumerateSwapchainImages(Call& call, XrSwapchain handle, std::uint32_t capacity,
                                  std::uint32_t* count, XrSwapchainImageBaseHeader* images) {
    const Swapchain& swapchain = call.live<Swapchain>(handle);
    auto* vulkan_images = reinterpret_cast<XrSwapchainImageVulkanKHR*>(images);
    checkElements(capacity, vulkan_images, swapchain.images.images.size(),
                  XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR);
    return twoCall(capacity, count, vulkan_images, swapchain.images.images,
                   [](const DeviceImage& each, XrSwapchainImageVulkanKHR& out) { out.image = each.image; });
}

XrResult acquireSwapchainImage(Call& call, XrSwapchain handle, const XrSwapchainImageAcquireInfo* info,
                               std::uint32_t* index) {
    Swapchain& swapchain = call.live<Swapchain>(handle);
    if (info != nullptr) requireStruct(info, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
    requireValid(index != nullptr, "index is null");
    require(!swapchain.free_images.empty(), XR_ERROR_CALL_ORDER_INVALID,
            swapchain.is_static ? "a static image is acquired once" : "all images are acquired");
    transitionToRestingLayout(swapchain.session.device, swapchain.images);
    *index = swapchain.free_images.front();
    swapchain.acquired.push_back(*index);
    swapchain.free_images.pop_front();
    return XR_SUCCESS;
}

XrResult waitSwapchainImage(Call& call, XrSwapchain handle, const XrSwapchainImageWaitInfo* info) {
    Swapchain& swapchain = call.live<Swapchain>(handle);
    requireStruct(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    require(!swapchain.acquired.empty() && !swapchain.oldest_waited, XR_ERROR_CALL_ORDER_INVALID,
            "no image is acquired, or the oldest was waited for already");
    swapchain.oldest_waited = true;  // nothing to wait for: xrEndFrame reads images only until it returns
    return XR_SUCCESS;
}

XrResult releaseSwapchainImage(Call& call, XrSwapchain handle, const XrSwapchainImageReleaseInfo* info) {
    Swapchain& swapchain = call.live<Swapchain>(handle);
    if (info != nullptr) requireStruct(info, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
    require(swapchain.oldest_waited, XR_ERROR_CALL_ORDER_INVALID, "no image was waited for");
    swapchain.oldest_waited = false;
    swapchain.last_released = swapchain.acquired.front();
    swapchain.acquired.pop_front();
    if (!swapchain.is_static) swapchain.free_images.push_back(*swapchain.last_released);
    return XR_SUCCESS;
}

}  // namespace xrmock
