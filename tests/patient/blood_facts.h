// Flow directions that hold in every liver, checked independently of how they were computed.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "patient/patient.h"

namespace stylet::test {

// Mean velocity at one end of the vessels of a kind: over the voxels within `reach_m` of the outermost one
// toward `side`.
inline Vec3 meanFlowAtEnd(const patient::Patient& patient, const patient::VesselFlow& flow,
                          patient::BloodKind kind, const Vec3& side, double reach_m) {
    const Grid& grid = flow.grid;
    double furthest = -1e9;
    Vec3 sum(0.0);
    double count = 0.0;
    for (const bool summing : {false, true})
        forEachVoxel(grid, [&](const Index3& i) {
            if (flow.kindAt(i) != kind) return;
            const Vec3 p = grid.centre(i);
            const double along = glm::dot(p, side);
            if (!summing) furthest = std::max(furthest, along);
            if (summing && along > furthest - reach_m) sum += flow.meanAt_m_per_s(p), count += 1.0;
        });
    EXPECT_GT(count, 10.0) << "no such vessel in " << patient.package().name;
    return sum / std::max(count, 1.0);
}

// RAS: +x is the patient's right.
inline void expectBloodFlowDirections(const patient::Patient& patient) {
    using patient::BloodKind;
    const patient::VesselFlow flow = patient::makeVesselFlow(patient);
    ASSERT_FALSE(flow.velocity.empty());
    const auto mean = [&](BloodKind kind, const Vec3& side, double reach_m) {
        return meanFlowAtEnd(patient, flow, kind, side, reach_m);
    };
    EXPECT_GT(mean(BloodKind::portal, {0, 0, -1}, 0.03).z, 0.03) << "mesenteric vein: toward the head";
    EXPECT_GT(mean(BloodKind::portal, {-1, 0, 0}, 0.03).x, 0.03) << "splenic vein: toward the right";
    EXPECT_GT(mean(BloodKind::portal, {1, 0, 0}, 0.03).x, 0.0) << "right branches: into the right lobe";
    EXPECT_LT(mean(BloodKind::hepatic, {1, 0, 0}, 0.03).x, 0.0) << "right hepatic vein: out of it";
    EXPECT_GT(mean(BloodKind::cava, {0, 0, 1}, 1.0).z, 0.05) << "vena cava: toward the heart";
    EXPECT_LT(mean(BloodKind::artery, {0, 0, 1}, 1.0).z, -0.05) << "aorta: away from it";
}

}  // namespace stylet::test
