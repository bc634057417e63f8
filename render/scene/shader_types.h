// The shaders' types in C++, for the *_shared.h headers, which C++ and GLSL both include.
#ifndef STYLET_RENDER_SHADER_TYPES_H
#define STYLET_RENDER_SHADER_TYPES_H

// For constants that are not integers. In C++ a plain const of such a type is not constexpr.
#ifdef __cplusplus
#define SHADER_CONSTANT inline constexpr
#else
#define SHADER_CONSTANT const
#endif

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
#include <glm/ext/vector_uint4.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace stylet::render::gpu {
using glm::mat4;
using glm::uvec4;
using glm::vec3;
using glm::vec4;
using uint = std::uint32_t;
}  // namespace stylet::render::gpu
#endif
#endif
