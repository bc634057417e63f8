// Writes valid DICOM slices as bytes (explicit VR, little endian). Tests then corrupt them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace stylet::test {

inline constexpr const char* kRunLength = "1.2.840.10008.1.2.5";

struct DicomSlice {
    int columns = 4, rows = 3;
    std::array<double, 2> spacing_mm{0.8, 0.8};  // between rows, between columns (order of the standard)
    std::array<double, 3> position_mm{};         // LPS
    std::array<double, 6> orientation{1, 0, 0, 0, 1, 0};
    double slope = 1.0, intercept = 0.0;
    std::string series = "1.2.3.4", modality = "CT", instance = "1.2.3.4.1", description;
    std::string sop_class = "1.2.840.10008.5.1.4.1.1.2";  // CT image
    std::string syntax = "1.2.840.10008.1.2.1";           // named in the header: explicit VR, little endian
    bool run_length = false;                              // pixels are encoded as kRunLength
    int frames = 1;
    std::set<std::uint32_t> without;  // tags to leave out, such as 0x00200032
    std::vector<std::int16_t> stored;
};

std::vector<char> dicomBytes(const DicomSlice&);
void writeFile(const std::filesystem::path&, const std::vector<char>&);

}  // namespace stylet::test
