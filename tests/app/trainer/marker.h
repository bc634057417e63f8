// Writes a CSV file with the motion of a marker on a breathing abdomen.
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace stylet::test {

// Ten breaths of `period_s` each. The depth changes from breath to breath.
inline void writeMarker(const std::filesystem::path& csv, double period_s) {
    constexpr double kPi = 3.14159265358979323846;
    std::ofstream out(csv);
    out << "Frame;Timestamp;x;y;z\n";
    for (int i = 0; i * 0.1 <= 10.0 * period_s; ++i) {
        const double breaths = i * 0.1 / period_s, depth = 1.0 + 0.1 * std::sin(2.1 * std::floor(breaths));
        const double z_mm = 60.0 + 12.0 * depth * (0.5 - 0.5 * std::cos(2.0 * kPi * breaths));
        char row[80];
        std::snprintf(row, sizeof row, "%d;%d;-400.0;3.0;%.4f\n", i, 100 * i, z_mm);
        out << row;
    }
}

}  // namespace stylet::test
