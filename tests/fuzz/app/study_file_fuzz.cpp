#include <set>

#include "app/study/pair.h"
#include "tests/fuzz/parser_target.h"

// The result is a study or a DataError. Each pair of an accepted study has a unique folder name.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    const study::StudyFile file = study::parseStudyFile(input, "folder/fuzz.toml");
    std::set<std::string> names;
    for (const study::PairFiles& pair : file.pairs) {
        if (pair.name.empty() || pair.name.find('/') != std::string::npos) std::abort();
        if (!names.insert(pair.name).second) std::abort();
    }
    if (file.pairs.empty()) std::abort();
}
