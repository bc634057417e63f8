#include "render/volume/deform_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace stylet::render {
namespace {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));

#if defined(__x86_64__)
namespace wide {

#define ROW_TARGET __attribute__((target("avx2,fma")))
#define ROW_FN ROW_TARGET __attribute__((always_inline)) inline

ROW_FN __m256 lerp(__m256 a, __m256 b, __m256 f) {
    return _mm256_fmadd_ps(f, _mm256_sub_ps(b, a), a);
}

// Interpolates both neighbours along x at once.
ROW_FN Float4 fetchNode(const float* n, std::size_t row, std::size_t plane, Float4 f) {
    const __m256 fy = _mm256_broadcastss_ps(_mm_shuffle_ps(f, f, 0x55));
    const __m256 fz = _mm256_broadcastss_ps(_mm_shuffle_ps(f, f, 0xaa));
    const __m256 near = lerp(_mm256_loadu_ps(n), _mm256_loadu_ps(n + row), fy);
    const __m256 far = lerp(_mm256_loadu_ps(n + plane), _mm256_loadu_ps(n + plane + row), fy);
    const __m256 both = lerp(near, far, fz);
    const __m128 low = _mm256_castps256_ps128(both), high = _mm256_extractf128_ps(both, 1);
    return _mm_fmadd_ps(_mm_shuffle_ps(f, f, 0), _mm_sub_ps(high, low), low);
}

#include "render/volume/deform_rows.inl"

#undef ROW_FN
#undef ROW_TARGET

}  // namespace wide
#endif

namespace portable {

#define ROW_TARGET
#define ROW_FN inline

ROW_FN Float4 nodeAt(const float* n) {
    Float4 node;
    std::memcpy(&node, n, sizeof node);
    return node;
}

ROW_FN Float4 fetchNode(const float* n, std::size_t row, std::size_t plane, Float4 f) {
    const auto lerp = [](Float4 a, Float4 b, float s) { return a + s * (b - a); };
    const auto along = [&](const float* at) { return lerp(nodeAt(at), nodeAt(at + 4), f[0]); };
    return lerp(lerp(along(n), along(n + row), f[1]), lerp(along(n + plane), along(n + plane + row), f[1]),
                f[2]);
}

#include "render/volume/deform_rows.inl"

#undef ROW_FN
#undef ROW_TARGET

}  // namespace portable
}  // namespace

RowKernels portableRows() {
    return {portable::wallRow, portable::tableRow};
}

RowKernels widestRows() {
#if defined(__x86_64__)
    static const bool can = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (can) return {wide::wallRow, wide::tableRow};
#endif
    return portableRows();
}

}  // namespace stylet::render
