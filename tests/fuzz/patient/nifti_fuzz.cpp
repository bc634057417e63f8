#include <cstddef>
#include <cstdint>
#include <span>

#include "patient/package/nifti.h"
#include "patient/package/package.h"

// The result is a volume or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    try {
        stylet::patient::parseNifti<std::int16_t>("fuzz.nii", bytes);
    } catch (const stylet::DataError&) {
    }
    try {
        stylet::patient::parseNifti<std::uint8_t>("fuzz.nii", bytes);
    } catch (const stylet::DataError&) {
    }
    return 0;
}
