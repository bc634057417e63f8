#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "app/modeller/segmentation/stage_store.h"

// The result is a record or a DataError. An accepted record survives a write and parse round trip, and its
// notes contain no terminal escape sequences.
// HZ-RECORD-11, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::modeller;
    try {
        const StageFile file =
            parseStageFile("fuzz.json", std::string(reinterpret_cast<const char*>(data), size));
        for (const std::string& note : file.record.notes)
            if (note.find('\033') != std::string::npos) std::abort();
        const StageFile again = parseStageFile("again.json", writeStageFile(file));
        if (again.record.key != file.record.key || again.record.notes != file.record.notes ||
            again.labels_digest != file.labels_digest || again.record.seconds != file.record.seconds)
            std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
