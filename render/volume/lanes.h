// Four floats in a SIMD register, and trilinear look-ups in tables of such values. Private to this folder.
// All functions are static, because the files that use them differ in their floating-point options.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace stylet::render {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));

#if defined(__x86_64__)
namespace avx2 {

#define LANES_FN __attribute__((target("avx2,fma"), always_inline)) static inline

LANES_FN __m256 lerp(__m256 a, __m256 b, __m256 f) {
    return _mm256_fmadd_ps(f, _mm256_sub_ps(b, a), a);
}

// The two halves of each vector hold the neighbours along x.
LANES_FN Float4 blend(__m256 near_low, __m256 near_high, __m256 far_low, __m256 far_high, Float4 f) {
    const __m256 fy = _mm256_broadcastss_ps(_mm_shuffle_ps(f, f, 0x55));
    const __m256 fz = _mm256_broadcastss_ps(_mm_shuffle_ps(f, f, 0xaa));
    const __m256 both = lerp(lerp(near_low, near_high, fy), lerp(far_low, far_high, fy), fz);
    const __m128 low = _mm256_castps256_ps128(both), high = _mm256_extractf128_ps(both, 1);
    return _mm_fmadd_ps(_mm_shuffle_ps(f, f, 0), _mm_sub_ps(high, low), low);
}

// Interpolates a table of four floats per node. `row`, `plane`: distances in floats.
LANES_FN Float4 fetchNode(const float* p, std::size_t row, std::size_t plane, Float4 f) {
    return blend(_mm256_loadu_ps(p), _mm256_loadu_ps(p + row), _mm256_loadu_ps(p + plane),
                 _mm256_loadu_ps(p + plane + row), f);
}

#undef LANES_FN

}  // namespace avx2
#endif

// The same without SIMD instructions.
namespace scalar {

__attribute__((always_inline)) static inline Float4 lerp(Float4 a, Float4 b, float f) {
    return a + f * (b - a);
}

// A texel of four bytes, or a node of four floats.
__attribute__((always_inline)) static inline Float4 cornerAt(const std::uint32_t* p) {
    const std::uint32_t c = *p;
    return Float4{float(c & 255u), float((c >> 8) & 255u), float((c >> 16) & 255u), float(c >> 24)};
}
__attribute__((always_inline)) static inline Float4 cornerAt(const float* p) {
    return Float4{p[0], p[1], p[2], p[3]};
}

// `next`, `row`, `plane`: distances between neighbours along x, y and z.
template <typename Value>
__attribute__((always_inline)) static inline Float4 fetch(const Value* p, std::size_t next, std::size_t row,
                                                          std::size_t plane, Float4 f) {
    const auto alongX = [&](const Value* at) { return lerp(cornerAt(at), cornerAt(at + next), f[0]); };
    return lerp(lerp(alongX(p), alongX(p + row), f[1]),
                lerp(alongX(p + plane), alongX(p + plane + row), f[1]), f[2]);
}

__attribute__((always_inline)) static inline Float4 fetchNode(const float* p, std::size_t row,
                                                              std::size_t plane, Float4 f) {
    return fetch(p, 4, row, plane, f);
}

}  // namespace scalar
}  // namespace stylet::render
