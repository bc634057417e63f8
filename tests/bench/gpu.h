// A bench that needs a GPU begins with: if (!hasGpu("its name")) return;
#pragma once

#include <cstdio>

#include "tests/render/pictures.h"

namespace stylet::bench {

// Returns false and prints the reason if there is no GPU.
inline bool hasGpu(const char* bench) {
    const std::string why = test::noGpuReason();
    if (!why.empty()) std::fprintf(stderr, "%s: %s\n", bench, why.c_str());
    return why.empty();
}

}  // namespace stylet::bench
