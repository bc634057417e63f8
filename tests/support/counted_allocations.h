// A program that links counted_allocations.cpp counts every operator new.
#pragma once

#include <cstdint>

namespace stylet::test {

std::uint64_t allocations() noexcept;  // number so far, over all threads

}  // namespace stylet::test
