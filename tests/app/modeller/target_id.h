// Label id of a structure in a package.
#pragma once

#include <cstdint>

#include "app/modeller/import/import.h"

namespace stylet::test {

inline std::uint8_t idOf(const char* name) {
    return modeller::findTarget(name)->id;
}

}  // namespace stylet::test
