// A program that links counted_allocations.cpp counts every operator new.
#pragma once

#include <cstdint>

namespace stylet::test {

std::uint64_t allocations() noexcept;  // of all threads, so far

}  // namespace stylet::test
