#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "app/modeller/segmentation/classes.h"
#include "base/errors.h"

// The result is a set of rising thresholds or a DataError. Accepted thresholds survive a write and parse
// round trip.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::modeller;
    try {
        const stylet::patient::Thresholds t =
            parseClasses(std::string(reinterpret_cast<const char*>(data), size));
        if (!(t.t0_hu >= -1024.0 && t.t0_hu < t.t1_hu && t.t1_hu < t.t2_sensitive_hu)) std::abort();
        if (!(parseClasses(writeClasses({}, t)) == t)) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
