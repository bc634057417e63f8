// Where the shipped scenarios and those of the tests are.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace stylet::test {

inline std::filesystem::path assets() {
    const char* folder = std::getenv("STYLET_ASSETS");
    if (!folder) throw std::runtime_error("STYLET_ASSETS is not set: run through ctest");
    return folder;
}

inline std::filesystem::path testScenario(const std::string& name) {
    return assets().parent_path() / "tests" / "scenarios" / (name + ".toml");
}

}  // namespace stylet::test
