// The error of the modeller.
#pragma once

#include <stdexcept>

namespace stylet::modeller {

// A scan, a segmentation or a stage cannot be used. what() is one sentence that names the file; unlike
// DataError's, it may be one that a child process printed.
class ImportError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

}  // namespace stylet::modeller
