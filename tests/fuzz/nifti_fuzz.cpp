#include <cstddef>
#include <cstdint>
#include <span>

#include "patient/nifti.h"
#include "patient/package.h"

// A volume or a DataError; anything else is a bug.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    try {
        stylet::patient::parseNifti<std::int16_t>("fuzz.nii", bytes);
    } catch (const stylet::patient::DataError&) {
    }
    try {
        stylet::patient::parseNifti<std::uint8_t>("fuzz.nii", bytes);
    } catch (const stylet::patient::DataError&) {
    }
    return 0;
}
