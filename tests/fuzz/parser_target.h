// The entry point of a fuzz target for a parser that refuses bad input with DataError. The target defines
// fuzz::parse(), which aborts if an accepted input gives an invalid result. Include it in the target only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "base/errors.h"

namespace fuzz {

void parse(std::string_view input);

inline std::span<const std::uint8_t> bytesOf(std::string_view input) {
    return {reinterpret_cast<const std::uint8_t*>(input.data()), input.size()};
}

}  // namespace fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        fuzz::parse({reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
