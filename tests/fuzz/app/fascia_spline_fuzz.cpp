#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/modeller/wall/fascia_spline.h"
#include "base/errors.h"

// The result is a surface with a valid radius everywhere or a DataError. An accepted surface survives a
// write and parse round trip.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::modeller;
    try {
        const FasciaSpline s = parseFascia("fuzz.txt", {reinterpret_cast<const char*>(data), size});
        for (const double phi : {-9.0, 0.0, 3.0})
            for (const double h : {-20.0, s.h_begin_m, 20.0})
                if (!(s.radiusAt(phi, h) > 0.0009 && s.radiusAt(phi, h) < 1.001)) std::abort();
        if (parseFascia("again.txt", writeFascia(s)).control_m.size() != s.control_m.size()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
