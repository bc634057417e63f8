// Plots of a force table: for each tissue the force over the depth behind its border, in and out; and a
// comparison of two needles along one path.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "haptics/tools/exact.h"

namespace stylet::report {

struct DepthForce {
    double depth_m = 0.0;  // behind the tissue's border
    double force_n = 0.0;
};

// A needle moved through `before` into `tissue` and out again, sampled at 1 kHz and 10 mm/s.
struct TissueCurve {
    haptics::Tissue before = haptics::Tissue::air, tissue = haptics::Tissue::skin;
    std::vector<DepthForce> in, out;
    // The exact solver's insertion with a1 = 0 and a1 = k: the bounds of Eq. 1.
    std::vector<DepthForce> min_a1, max_a1;
    bool cut = false;  // punctured after tenting, at cut_at
    DepthForce cut_at;
};

// One curve per tissue except air. The needle enters each from the tissue before it on a path to a bile duct.
std::vector<TissueCurve> tissueCurves(const patient::TissueTable&, const haptics::NeedleSettings&);
// Throws DataError.
void drawTissueCurves(const std::vector<TissueCurve>&, const patient::TissueTable&,
                      const std::filesystem::path& png);

// A note on an interval of the path, for two needles along the same path.
struct Remark {
    double begin_m = 0.0, end_m = 0.0;
    std::string title, text;
};
struct Comparison {
    std::string title, first_name, second_name;
    std::vector<haptics::Segment> tissues;  // of the first needle, for the bands
    double length_m = 0.0;
    std::vector<DepthForce> first, second;
    std::vector<Remark> remarks;
};
void drawComparison(const Comparison&, const std::filesystem::path& png);

}  // namespace stylet::report
