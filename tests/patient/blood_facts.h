// Flow directions that hold in every liver, checked independently of how they were computed.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "patient/patient.h"

namespace stylet::test {

// Mean velocity over the voxels of one kind that lie within `reach_m` of its outermost voxel toward `side`.
inline Vec3 meanFlowAtTheEnd(const patient::Patient& patient, const patient::VesselFlow& flow,
                             patient::BloodKind kind, const Vec3& side, double reach_m) {
    const Grid& grid = flow.grid;
    double furthest = -1e9;
    Vec3 sum(0.0);
    double count = 0.0;
    for (const bool summing : {false, true})
        for (int z = 0; z < grid.dims.z; ++z)
            for (int y = 0; y < grid.dims.y; ++y)
                for (int x = 0; x < grid.dims.x; ++x) {
                    if (flow.kindAt({x, y, z}) != kind) continue;
                    const Vec3 p = grid.centre({x, y, z});
                    const double along = p.x * side.x + p.y * side.y + p.z * side.z;
                    if (!summing) furthest = std::max(furthest, along);
                    if (summing && along > furthest - reach_m) sum += flow.meanAt_m_per_s(p), count += 1.0;
                }
    EXPECT_GT(count, 10.0) << "no such vessel in " << patient.package().name;
    return sum / std::max(count, 1.0);
}

// RAS: +x is the patient's right.
inline void expectBloodToGoItsWay(const patient::Patient& patient) {
    using patient::BloodKind;
    const patient::VesselFlow flow = patient::makeVesselFlow(patient);
    ASSERT_FALSE(flow.velocity.empty());
    const auto mean = [&](BloodKind kind, const Vec3& side, double reach_m) {
        return meanFlowAtTheEnd(patient, flow, kind, side, reach_m);
    };
    EXPECT_GT(mean(BloodKind::portal, {0, 0, -1}, 0.03).z, 0.03) << "mesenteric vein: toward the head";
    EXPECT_GT(mean(BloodKind::portal, {-1, 0, 0}, 0.03).x, 0.03) << "splenic vein: toward the right";
    EXPECT_GT(mean(BloodKind::portal, {1, 0, 0}, 0.03).x, 0.0) << "right branches: into the right lobe";
    EXPECT_LT(mean(BloodKind::hepatic, {1, 0, 0}, 0.03).x, 0.0) << "right hepatic vein: out of it";
    EXPECT_GT(mean(BloodKind::cava, {0, 0, 1}, 1.0).z, 0.05) << "vena cava: toward the heart";
    EXPECT_LT(mean(BloodKind::artery, {0, 0, 1}, 1.0).z, -0.05) << "aorta: away from it";
}

}  // namespace stylet::test
