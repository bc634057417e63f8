#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <set>

#include "app/study/pair.h"

// A study of pairs that each have a folder name of their own, or a DataError.
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
    } catch (const DataError&) {
    }
    return 0;
}
