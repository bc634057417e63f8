// A locale with a decimal comma. rough_surroundings.cpp activates it in a program under test.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

namespace stylet::test {

// Creates the locale and writes its files to `folder`. Returns the environment variables that activate it, or
// none if this machine's localedef cannot create it.
inline std::map<std::string, std::string> decimalComma(const std::filesystem::path& folder,
                                                       const std::string& rough_surroundings) {
    std::filesystem::create_directories(folder);
    const std::string locale = (folder / "de_DE.UTF-8").string();
    if (std::system(("localedef -i de_DE -f UTF-8 '" + locale + "' >/dev/null 2>&1").c_str()) != 0) return {};
    return {{"LOCPATH", folder.string()},
            {"LC_ALL", "de_DE.UTF-8"},
            {"STYLET_TEST_LOCALE", "1"},
            {"LD_PRELOAD", rough_surroundings}};
}

}  // namespace stylet::test
