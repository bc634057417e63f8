// Acoustic properties: impedance, attenuation, speed and scatter of each tissue, and the rules that assign
// labels and CT values to them. Loaded from assets/ultrasound/tissues.toml.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"
#include "render/scene/label_rule.h"
#include "render/ultrasound/scan_shared.h"

namespace stylet::render {

inline constexpr int kMaxAcoustics = gpu::kMaxTissues;

struct Acoustic {
    std::string name;
    double impedance_rayl = 1.6e6;
    double attenuation_db_per_m_mhz = 70.0;  // one way
    double speed_m_per_s = 1540.0;
    double scatter_db = -45.0;  // mean backscatter relative to a perfect mirror's echo
    // Variation with the CT value: a voxel of hu_centre + hu_span has an impedance larger by the share
    // impedance_by_hu and scatter_by_hu_db more scatter.
    double hu_centre = 0.0, hu_span = 0.0;  // span 0: the CT value has no effect
    double impedance_by_hu = 0.0, scatter_by_hu_db = 0.0;
    std::optional<double> wall_db;  // scatter of a wall inside its border
    double wall_m = 0.0;
    bool solid = false;  // injected fluid does not displace it
    std::string source;
};

struct AcousticRule : LabelRule {
    int acoustic = 0;  // index of AcousticTable::acoustics
};

struct HuClass {
    double from_hu = 0.0;
    int acoustic = 0;
};

struct AcousticTable {
    std::vector<Acoustic> acoustics;  // at most kMaxAcoustics
    std::vector<AcousticRule> rules;
    std::vector<HuClass> hu;  // ascending; the first also applies below its from_hu
    double roughness = 0.0;   // share of a border's reflection that is scattered in all directions
    int air = 0, gel = 0, steel = 0;

    int acousticForHu(double hu_value) const;  // for voxels that no rule matches
};

AcousticTable loadAcoustics(const std::filesystem::path& toml);  // throws DataError
// The same from memory; errors name `file`.
AcousticTable parseAcoustics(const std::filesystem::path& file, std::string_view toml);

// Row of each label id; -1: by CT value.
std::array<int, 256> acousticsByLabel(const AcousticTable&, const patient::Patient&);

// Reflectivity of a plane border at a right angle.
double reflectivity(const Acoustic& from, const Acoustic& to);

}  // namespace stylet::render
