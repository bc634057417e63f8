#include <string>

#include "app/modeller/segmentation/stage_store.h"
#include "tests/fuzz/parser_target.h"

// The result is a record or a DataError. An accepted record survives a write and parse round trip, and its
// notes contain no terminal escape sequences.
// HZ-RECORD-11, HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::modeller;
    const StageFile file = parseStageFile("fuzz.json", std::string(input));
    for (const std::string& note : file.record.notes)
        if (note.find('\033') != std::string::npos) std::abort();
    const StageFile again = parseStageFile("again.json", writeStageFile(file));
    if (again.record.key != file.record.key || again.record.notes != file.record.notes ||
        again.record.atlases != file.record.atlases ||
        again.record.virtual_ducts != file.record.virtual_ducts ||
        again.record.labels_replaced != file.record.labels_replaced ||
        again.labels_digest != file.labels_digest || again.record.seconds != file.record.seconds)
        std::abort();
}
