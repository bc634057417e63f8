// The shaders, as the build made them: SPIR-V words.
#pragma once

#include <cstdint>

namespace xrmock {

inline constexpr std::uint32_t kVertexShader[] =
#include "compositor.vert.inc"
    ;
inline constexpr std::uint32_t kFragmentShader[] =
#include "compositor.frag.inc"
    ;

}  // namespace xrmock
