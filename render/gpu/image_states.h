// Image states used by more than one source file.
#pragma once

#include "render/gpu/memory.h"

namespace stylet::render {

inline constexpr auto kColour = vk::ImageAspectFlagBits::eColor;

inline constexpr ImageState kFreshImage{
    vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eAllCommands, {}};
inline constexpr ImageState kColourDrawn{
    vk::ImageLayout::eColorAttachmentOptimal, vk::PipelineStageFlagBits2::eColorAttachmentOutput,
    vk::AccessFlagBits2::eColorAttachmentWrite | vk::AccessFlagBits2::eColorAttachmentRead};
inline constexpr ImageState kDepthRead{
    vk::ImageLayout::eShaderReadOnlyOptimal,
    vk::PipelineStageFlagBits2::eFragmentShader | vk::PipelineStageFlagBits2::eComputeShader,
    vk::AccessFlagBits2::eShaderSampledRead};

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

}  // namespace stylet::render
