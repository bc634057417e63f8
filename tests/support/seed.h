// The seed of a test's random numbers: drawn once per program and printed, or given to repeat an earlier run.
#pragma once

#include <cstdint>

namespace stylet::test {

// Returns the value of STYLET_TEST_SEED if it is set, else a number drawn at the first call. Prints it at the
// first call, so that a failure can be repeated. Throws std::runtime_error if STYLET_TEST_SEED is not a whole
// number.
std::uint64_t seed();

}  // namespace stylet::test
