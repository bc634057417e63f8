#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/modeller/import/import_map.h"
#include "base/errors.h"

// The result is a label map or a DataError. An accepted map maps int16 ids to existing targets.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::modeller;
    try {
        const LabelMap map = parseLabelMap("fuzz.csv", {reinterpret_cast<const char*>(data), size});
        if (map.target_of.empty()) std::abort();
        for (const auto& [id, target] : map.target_of)
            if (id < 0 || id > 32767 || target > targetTable().size()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
