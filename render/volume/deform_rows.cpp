#include "render/volume/deform_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "render/volume/lanes.h"

namespace stylet::render {
namespace {

#if defined(__x86_64__)
namespace wide {

#define ROW_TARGET __attribute__((target("avx2,fma")))
#define ROW_FN ROW_TARGET __attribute__((always_inline)) inline

using avx2::fetchNode;

#include "render/volume/deform_rows.inl"

#undef ROW_FN
#undef ROW_TARGET

}  // namespace wide
#endif

namespace portable {

#define ROW_TARGET
#define ROW_FN inline

using scalar::fetchNode;

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
