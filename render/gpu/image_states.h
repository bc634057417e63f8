// Image states and memory uses that several source files share.
#pragma once

#include "render/gpu/memory.h"

namespace stylet::render {

inline constexpr auto kColour = vk::ImageAspectFlagBits::eColor;

inline constexpr ImageState kFreshImage{
    vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eAllCommands, {}};
inline constexpr ImageState kColourDrawn{
    vk::ImageLayout::eColorAttachmentOptimal, vk::PipelineStageFlagBits2::eColorAttachmentOutput,
    vk::AccessFlagBits2::eColorAttachmentWrite | vk::AccessFlagBits2::eColorAttachmentRead};

// Sampled by shaders of these stages.
constexpr ImageState sampledIn(vk::PipelineStageFlags2 stages) {
    return {vk::ImageLayout::eShaderReadOnlyOptimal, stages, vk::AccessFlagBits2::eShaderSampledRead};
}
inline constexpr ImageState kFragmentRead = sampledIn(vk::PipelineStageFlagBits2::eFragmentShader);
inline constexpr ImageState kComputeRead = sampledIn(vk::PipelineStageFlagBits2::eComputeShader);
inline constexpr ImageState kShaderRead =
    sampledIn(vk::PipelineStageFlagBits2::eFragmentShader | vk::PipelineStageFlagBits2::eComputeShader);

inline constexpr ImageState kUnused{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eNone, {}};
inline constexpr ImageState kCopyRead{vk::ImageLayout::eTransferSrcOptimal, vk::PipelineStageFlagBits2::eCopy,
                                      vk::AccessFlagBits2::eTransferRead};
inline constexpr ImageState kTransferFresh{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eTransfer,
                                           vk::AccessFlagBits2::eNone};
inline constexpr ImageState kTransferRead{vk::ImageLayout::eTransferSrcOptimal,
                                          vk::PipelineStageFlagBits2::eTransfer,
                                          vk::AccessFlagBits2::eTransferRead};
inline constexpr ImageState kTransferWritten{vk::ImageLayout::eTransferDstOptimal,
                                             vk::PipelineStageFlagBits2::eTransfer,
                                             vk::AccessFlagBits2::eTransferWrite};
inline constexpr ImageState kCopyWritten{vk::ImageLayout::eTransferDstOptimal,
                                         vk::PipelineStageFlagBits2::eCopy,
                                         vk::AccessFlagBits2::eTransferWrite};

inline constexpr MemoryUse kCopyWrites{vk::PipelineStageFlagBits2::eCopy,
                                       vk::AccessFlagBits2::eTransferWrite};
inline constexpr MemoryUse kComputeWrites{vk::PipelineStageFlagBits2::eComputeShader,
                                          vk::AccessFlagBits2::eShaderStorageWrite};
inline constexpr MemoryUse kHostReads{vk::PipelineStageFlagBits2::eHost, vk::AccessFlagBits2::eHostRead};

}  // namespace stylet::render
