#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "app/modeller/segmentation/stage_store.h"

// A record or a DataError; what is taken is written so that it is taken again, and fits a terminal.
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
