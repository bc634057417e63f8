#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <set>

#include "app/study/pair.h"

// The result is a study or a DataError. Each pair of an accepted study has a unique folder name.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    try {
        const study::StudyFile file =
            study::parseStudyFile({reinterpret_cast<const char*>(data), size}, "folder/fuzz.toml");
        std::set<std::string> names;
        for (const study::PairFiles& pair : file.pairs) {
            if (pair.name.empty() || pair.name.find('/') != std::string::npos) std::abort();
            if (!names.insert(pair.name).second) std::abort();
        }
        if (file.pairs.empty()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
