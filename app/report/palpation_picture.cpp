#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/report/canvas.h"
#include "app/report/palpation.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::report {

namespace {

constexpr double kSpot = 13.0;  // pixels per spot
constexpr int kMapMargin = 64, kMapTop = 96, kMapBelow = 74, kBar = 18, kProfile = 300, kMapGap = 96;
constexpr Colour kPaper{1.0, 1.0, 1.0}, kInk{0.12, 0.13, 0.15}, kMapGrey{0.45, 0.47, 0.50};
constexpr Colour kMapBone{1.0, 1.0, 1.0}, kBand{0.90, 0.87, 0.80}, kLine{0.13, 0.33, 0.60};

// Dark, cold colours are soft; bright, warm colours are stiff. Lightness increases evenly.
Colour heatColour(double share) {
    constexpr std::array<Colour, 6> kStops{{{0.05, 0.03, 0.20},
                                            {0.30, 0.07, 0.42},
                                            {0.55, 0.15, 0.41},
                                            {0.80, 0.27, 0.30},
                                            {0.96, 0.50, 0.15},
                                            {0.98, 0.85, 0.35}}};
    return interpolate(kStops, share);
}

const PalpatedSpot& spotAt(const PalpationMap& map, int column, int row) {
    return map.spots[std::size_t(row * map.columns + column)];
}

// The scale's maximum in N/m: at least the 98th percentile of the spots, with round quarters.
double scaleMaximum(const PalpationMap& map) {
    std::vector<double> k;
    for (const PalpatedSpot& s : map.spots)
        if (s.on_skin) k.push_back(s.stiffness_n_per_m);
    if (k.empty()) return 1.0;
    return 40.0 * std::ceil(lowerQuantile(std::move(k), 0.98) / 40.0);
}

class PalpationSheet {
  public:
    PalpationSheet(const PalpationMap& map, const std::string& title)
        : map_(map),
          wide_(map.columns * kSpot),
          high_(map.rows * kSpot),
          scale_max_(scaleMaximum(map)),
          profile_x_(kMapMargin + wide_ + kBar + 2 * kMapGap),
          canvas_(int(profile_x_) + kProfile + kMapMargin, int(kMapTop + high_) + kMapBelow, kPaper) {
        canvas_.text({kMapMargin, 38}, title, {21, kInk, Align::left, true});
    }

    void drawMap() {
        for (int row = 0; row < map_.rows; ++row)
            for (int column = 0; column < map_.columns; ++column) {
                const PalpatedSpot& s = spotAt(map_, column, row);
                if (s.on_skin)
                    canvas_.rectangle(x(column), y(row), kSpot + 0.5, kSpot + 0.5,
                                      heatColour(s.stiffness_n_per_m / scale_max_));
            }
        outlineBones();
        const TextStyle label{14, kMapGrey, Align::centre};
        canvas_.text({kMapMargin, kMapTop - 12}, "Stiffness under the finger; ribs outlined",
                     {15, kInk, Align::left, true});
        canvas_.text({kMapMargin + 0.5 * wide_, kMapTop + high_ + 22},
                     "front  -  right flank, seen from the right  -  back", label);
        canvas_.textUpward({kMapMargin - 14, kMapTop + 0.5 * high_}, "foot  -  head", label);
        const double bar = 0.020 / map_.pitch_m * kSpot;
        canvas_.line({kMapMargin + 8, kMapTop + high_ - 12}, {kMapMargin + 8 + bar, kMapTop + high_ - 12}, 3,
                     kMapBone);
        canvas_.text({kMapMargin + 8 + 0.5 * bar, kMapTop + high_ - 19}, "20 mm",
                     {12, kMapBone, Align::centre});
    }

    void drawScale() {
        const double left = kMapMargin + wide_ + 20;
        constexpr int kSteps = 100;
        for (int i = 0; i < kSteps; ++i)
            canvas_.rectangle(left, kMapTop + high_ * i / kSteps, kBar, high_ / kSteps + 0.6,
                              heatColour(1.0 - (i + 0.5) / kSteps));
        for (int i = 0; i <= 4; ++i)
            canvas_.text({left + kBar + 6, kMapTop + high_ * (1.0 - 0.25 * i) + 5},
                         fmt::format("{:.2f}", 0.25e-3 * i * scale_max_), {13, kInk});
        canvas_.text({left, kMapTop - 12}, "N/mm", {13, kInk});
    }

    // The stiffness along the middle column: what a finger feels when sliding from head to feet.
    void drawProfile() {
        const int column = map_.columns / 2;
        const auto at = [&](double k) { return profile_x_ + kProfile * std::min(k / scale_max_, 1.0); };
        std::vector<Point> line;
        for (int row = 0; row < map_.rows; ++row) {
            const PalpatedSpot& s = spotAt(map_, column, row);
            if (!s.on_skin) continue;
            if (s.over_bone) canvas_.rectangle(profile_x_, y(row), kProfile, kSpot + 0.5, kBand);
            line.push_back({at(s.stiffness_n_per_m), y(row) + 0.5 * kSpot});
        }
        for (int i = 0; i <= 4; ++i) {
            const double grid = at(0.25 * i * scale_max_);
            canvas_.line({grid, kMapTop}, {grid, kMapTop + high_}, 1, kMapGrey.faded(0.35));
            canvas_.text({grid, kMapTop + high_ + 22},
                         fmt::format("{:.2f}{}", 0.25e-3 * i * scale_max_, i < 4 ? "" : " N/mm"),
                         {13, kInk, Align::centre});
        }
        canvas_.polyline(line, 2.5, kLine);
        canvas_.text({profile_x_, kMapTop - 12}, "Along the middle line; bands: a rib",
                     {15, kInk, Align::left, true});
    }

    void drawStatistics() {
        canvas_.text({kMapMargin, 64},
                     fmt::format("Pearson r against the rib mask {:.2f}   |   middle of a rib {:.3f}, of a "
                                 "gap {:.3f} N/mm: {:.1f} to 1   |   all spots {:.1f} to 1",
                                 map_.pearson, 1e-3 * map_.rib_n_per_m, 1e-3 * map_.gap_n_per_m,
                                 map_.ribOverGap(), map_.rib_over_gap_everywhere),
                     {14, kMapGrey});
    }

    void save(const std::filesystem::path& png) const { canvas_.savePng(png); }

  private:
    double x(int column) const { return kMapMargin + column * kSpot; }
    double y(int row) const { return kMapTop + row * kSpot; }
    bool bone(int column, int row) const {
        return column >= 0 && row >= 0 && column < map_.columns && row < map_.rows &&
               spotAt(map_, column, row).over_bone;
    }
    void outlineBones() {
        for (int row = 0; row <= map_.rows; ++row)
            for (int column = 0; column <= map_.columns; ++column) {
                if (bone(column, row) != bone(column - 1, row) && row < map_.rows)
                    canvas_.line({x(column), y(row)}, {x(column), y(row + 1)}, 1.6, kMapBone);
                if (bone(column, row) != bone(column, row - 1) && column < map_.columns)
                    canvas_.line({x(column), y(row)}, {x(column + 1), y(row)}, 1.6, kMapBone);
            }
    }

    const PalpationMap& map_;
    double wide_, high_, scale_max_, profile_x_;
    Canvas canvas_;
};

}  // namespace

void writePalpationCsv(const PalpationMap& map, const std::filesystem::path& file) {
    std::string csv = "y_m,z_m,x_m,stiffness_n_per_m,over_bone,bone_share,breath_v\n";
    for (const PalpatedSpot& s : map.spots)
        if (s.on_skin)
            csv += fmt::format("{:.5f},{:.5f},{:.5f},{:.3f},{:d},{:.3f},{:.4f}\n", s.reference_m.y,
                               s.reference_m.z, s.reference_m.x, s.stiffness_n_per_m, s.over_bone,
                               s.bone_share, s.breath_v);
    writeWholeFile(file, csv);
}

void drawPalpation(const PalpationMap& map, const std::string& title, const std::filesystem::path& png) {
    PalpationSheet sheet(map, title);
    sheet.drawMap();
    sheet.drawScale();
    sheet.drawProfile();
    sheet.drawStatistics();
    sheet.save(png);
}

}  // namespace stylet::report
