// Locations of the shipped scenarios and the test scenarios.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace stylet::test {

inline std::filesystem::path assets() {
    const char* folder = std::getenv("STYLET_ASSETS");
    if (!folder) throw std::runtime_error("STYLET_ASSETS is not set: run through ctest");
    return folder;
}

inline std::filesystem::path testScenario(const std::string& name) {
    return assets().parent_path() / "tests" / "scenarios" / (name + ".toml");
}

// Writes a scenario in which the scripted input stays outside the body for `seconds`. Returns `file`.
inline std::filesystem::path writeStillScenario(const std::filesystem::path& file, double seconds) {
    std::ofstream(file) << "name = \"still\"\nmoments = []\napproach_distance_mm = 5.0\n"
                           "[start]\ndeeper_mm = -10.0\n"
                           "[hand]\nramp_s = 0.1\ntremor_mm = 0.1\n"
                           "tremor_low_hz = 8.0\ntremor_high_hz = 10.0\n"
                           "[[stage]]\ndo = \"wait\"\nseconds = "
                        << std::to_string(seconds) << "\n";
    return file;
}

}  // namespace stylet::test
