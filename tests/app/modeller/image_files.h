// Writes hospital image files for tests and reads them with the reader program.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "app/modeller/image/import_image.h"
#include "tests/app/modeller/dicom_bytes.h"
#include "tests/support/refused.h"

namespace stylet::test {

inline modeller::ReaderLimits reader() {
    modeller::ReaderLimits limits;
    limits.program = std::filesystem::path(std::getenv("STYLET_BIN")) / "stylet-image-reader";
    limits.wall_s = 30;
    return limits;
}

// Error message of the reader, or empty if it accepts the image.
inline std::string readError(const std::filesystem::path& path, modeller::ImageKind kind,
                             const modeller::ReaderLimits& limits, const std::string& series = {}) {
    return errorText<modeller::ImportError>([&] { modeller::readImage(path, kind, limits, series); });
}
inline std::string readError(const std::filesystem::path& path) {
    return readError(path, modeller::ImageKind::ct, reader());
}

// A stack of `count` slices, 2.5 mm apart. Each stored value encodes its column, row and slice.
inline std::vector<DicomSlice> makeStack(int count) {
    std::vector<DicomSlice> slices;
    for (int k = 0; k < count; ++k) {
        DicomSlice s;
        s.position_mm = {-30.0, 12.0, 100.0 + 2.5 * k};
        s.instance = "1.2.3.4." + std::to_string(k + 1);
        for (int j = 0; j < s.rows; ++j)
            for (int i = 0; i < s.columns; ++i)
                s.stored.push_back(std::int16_t(i + 10 * j + 100 * k));
        slices.push_back(s);
    }
    return slices;
}

inline void writeStack(const std::filesystem::path& folder, const std::vector<DicomSlice>& slices) {
    std::filesystem::create_directories(folder);
    // File names are in reverse slice order: the reader must sort by position only.
    for (std::size_t k = 0; k < slices.size(); ++k)
        writeFile(folder / ("slice" + std::to_string(900 - k)), test::dicomBytes(slices[k]));
}

}  // namespace stylet::test
