// Internal: measurements of a package that several checks use.
#pragma once

#include <array>

#include "app/modeller/image/voxel_tools.h"
#include "app/modeller/import/import_map.h"
#include "patient/patient.h"

namespace stylet::modeller {

using patient::Label;
using patient::Package;
using patient::Patient;
using patient::Tissue;

// Returns true for liver tissue and for the vessels and ducts inside the liver. Their labels are `abdominal`.
inline bool isWholeLiver(const Label& l) {
    return l.tissue == Tissue::liver ||
           (l.abdominal && (l.tissue == Tissue::vessel || l.tissue == Tissue::duct));
}

// Computed once.
struct PackageStatistics {
    const Package& package;
    Patient patient;
    std::array<double, 256> voxels{}, hu{};  // per label id: number of voxels, sum of their HU
    std::array<Vec3, 256> centre_sum{};      // per label id: sum of the voxel centres
    double body_voxels = 0.0;
    Vec3 body_centre_sum{0.0};

    explicit PackageStatistics(const Package& p) : package(p), patient(p) {
        const Grid& g = p.labels.grid;
        forEachVoxel(g, [&](const Index3& i) {
            const std::size_t n = g.offset(i);
            const std::uint8_t id = p.labels.voxels[n];
            const Vec3 place = g.centre(i);
            ++voxels[id], hu[id] += p.ct.voxels[n], centre_sum[id] += place;
            if (inBody(i)) ++body_voxels, body_centre_sum += place;
        });
    }
    double voxel_ml() const {
        const Vec3 s = package.labels.grid.spacing_m;
        return 1e6 * s.x * s.y * s.z;
    }
    bool inBody(const Index3& i) const { return patient.at(i, {}).tissue != Tissue::air; }

    struct Sum {
        double voxels = 0.0, hu = 0.0;
        Vec3 centre_sum{0.0};
        double mean_hu() const { return hu / voxels; }
        Vec3 centre() const { return centre_sum / voxels; }
    };
    template <typename Wanted>
    Sum sum(const Wanted& wanted) const {
        Sum s;
        for (const Label& l : package.label_table)
            if (wanted(l)) s.voxels += voxels[l.id], s.hu += hu[l.id], s.centre_sum += centre_sum[l.id];
        return s;
    }
    Sum sum(Tissue t) const {
        return sum([t](const Label& l) { return l.tissue == t; });
    }
    // Lung labels on one side of the body's middle, by their centres.
    Sum lung(bool on_right) const {
        const double middle_m = body_centre_sum.x / body_voxels;
        return sum([&](const Label& l) {
            return isLung(l) && (centre_sum[l.id].x / voxels[l.id] > middle_m) == on_right;
        });
    }
};

}  // namespace stylet::modeller
