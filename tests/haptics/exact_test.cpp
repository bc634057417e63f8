#include "haptics/tools/exact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/traversal.h"
#include "tests/haptics/column.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum Tissue;

// Segments of a path that starts with 10 mm of air.
std::vector<Segment> makeSegments(const test::Layers& layers) {
    std::vector<Segment> out{{0.0, air, 0}};
    double x = 0.010;
    for (const auto& [tissue, thickness] : layers) {
        out.push_back({x, tissue, std::uint8_t(tissue)});
        x += thickness;
    }
    return out;
}

ExactForce solve(const test::Layers& layers, const NeedleSettings& settings = {}) {
    return solveExact(test::tissueDefaults().tissues, makeSegments(layers), 0.120, settings);
}

ExactEvent event(const ExactForce& exact, NeedleEventKind kind, Tissue tissue) {
    for (const ExactEvent& e : exact.events) {
        if (e.kind == kind && e.tissue == tissue) return e;
    }
    ADD_FAILURE() << "no such event into " << patient::tissueName(tissue);
    return {};
}

void expectCut(const ExactForce& exact, Tissue into, double behind_m, double before_n, double after_n) {
    const ExactEvent e = event(exact, NeedleEventKind::puncture, into);
    EXPECT_NEAR(e.depth_m - e.border_depth_m, behind_m, 1e-9);
    EXPECT_NEAR(e.force_before_n, before_n, 1e-9);
    EXPECT_NEAR(exact.at(e.depth_m - 1e-12), before_n, 1e-7);
    EXPECT_NEAR(exact.at(e.depth_m), after_n, 1e-9);
}

constexpr double kTable1_duct_m = 0.3 / 1000.0, kTable1_vessel_m = 0.15 / 1100.0;

// HZ-TEACH-02
TEST(Exact, ClosedFormsOfTable1) {
    const ExactForce e = solve({{skin, 0.002},
                                {soft, 0.02},
                                {fascia, 0.003},
                                {liver, 0.02},
                                {duct, 0.004},
                                {liver, 0.01},
                                {vessel, 0.004},
                                {liver, 0.02}});
    expectCut(e, skin, 0.000875, 0.7, 0.7);
    expectCut(e, fascia, 0.0018, 2.5, 1.0);
    expectCut(e, duct, kTable1_duct_m, 1.2, 0.5);
    expectCut(e, vessel, kTable1_vessel_m, 1.05, 0.75);
    for (const Tissue t : {soft, liver}) {
        const ExactEvent in = event(e, NeedleEventKind::entry, t);
        EXPECT_EQ(in.depth_m, in.border_depth_m);  // no puncture
    }
    EXPECT_NEAR(event(e, NeedleEventKind::entry, liver).force_after_n, 0.9, 1e-9);
    EXPECT_EQ(e.at(0.005), 0.0);
}

TEST(Exact, ThinFasciaPunctureEndsInTheLiver) {
    expectCut(solve({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.05}}), fascia, 0.0018, 2.5, 0.9);
}

TEST(Exact, FasciaLiverDuctInOneCut) {
    const ExactForce e =
        solve({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.0005}, {duct, 0.005}, {liver, 0.05}});
    const double border = 0.010 + 0.002 + 0.02;
    expectCut(e, fascia, 0.0018, 2.5, 0.9);
    const ExactEvent held = event(e, NeedleEventKind::border, duct);
    EXPECT_NEAR(held.depth_m, border + 0.0018, 1e-9);
    EXPECT_NEAR(held.force_before_n, 0.9, 1e-9);
    const ExactEvent cut = event(e, NeedleEventKind::puncture, duct);
    EXPECT_NEAR(cut.depth_m, border + 0.0018 + 0.0003, 1e-9);
    EXPECT_NEAR(cut.force_before_n, 1.2, 1e-9);
    EXPECT_NEAR(e.at(cut.depth_m), 0.5, 1e-9);
}

TEST(Exact, PiecesAreGapFreeAndJumpOnlyAtEvents) {
    const ExactForce e =
        solve({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.02}, {duct, 0.004}, {bone, 0.01}});
    EXPECT_EQ(e.pieces.front().begin_m, 0.0);
    EXPECT_EQ(e.pieces.back().end_m, 0.120);
    for (std::size_t i = 1; i < e.pieces.size(); ++i) {
        const ForcePiece &a = e.pieces[i - 1], &b = e.pieces[i];
        EXPECT_EQ(a.end_m, b.begin_m);
        const double x = a.end_m - a.begin_m;
        const double end_n = (a.c2_n_per_m2 * x + a.c1_n_per_m) * x + a.c0_n;
        bool at_event = false;
        for (const ExactEvent& v : e.events) {
            at_event = at_event || (v.depth_m == b.begin_m && v.kind != NeedleEventKind::border);
        }
        if (at_event) continue;
        EXPECT_NEAR(end_n, b.c0_n, 1e-12) << "at " << b.begin_m;
    }
}

TEST(Exact, BoneRisesToTheModelsMaximum) {
    const ExactForce e = solve({{skin, 0.002}, {soft, 0.01}, {bone, 0.05}});
    EXPECT_NEAR(e.at(0.022 + 0.003), 0.7 + 6.0, 1e-9);
    EXPECT_NEAR(e.at(0.120), 22.0, 1e-9);
}

TEST(Exact, APathThatBeginsInTissueMeetsItAtDepthZero) {
    const ExactForce e =
        solveExact(test::tissueDefaults().tissues, {{0.0, skin, 1}, {0.003, soft, 2}}, 0.01, {});
    const ExactEvent cut = event(e, NeedleEventKind::puncture, skin);
    EXPECT_NEAR(cut.depth_m, 0.000875, 1e-12);
}

TEST(Exact, LeavingThroughASkinCornerIsAnEvent) {
    // The skin is punctured at a depth of 0.875 mm. So the needle leaves a corner of 0.4 mm thickness before
    // the puncture, and one of 1.5 mm after it. A change of label within air does not count as entering the
    // body again.
    for (const double thickness_m : {0.0004, 0.0015}) {
        const ExactForce e =
            solve({{skin, thickness_m}, {air, 0.001}, {air, 0.002}, {skin, 0.002}, {soft, 0.02}});
        const ExactEvent out = event(e, NeedleEventKind::withdrawn, air);
        const double d = thickness_m;
        EXPECT_NEAR(out.depth_m, 0.010 + d, 1e-12);
        EXPECT_EQ(out.border_depth_m, out.depth_m);
        EXPECT_NEAR(out.force_before_n, d < 0.000875 ? 800.0 * d * (0.5 + 0.5 * d / 0.000875) : 0.7, 1e-9);
        EXPECT_EQ(out.force_after_n, 0.0);
        EXPECT_EQ(e.at(out.depth_m), 0.0);
        EXPECT_EQ(std::count_if(e.events.begin(), e.events.end(),
                                [](const ExactEvent& v) { return v.tissue == air; }),
                  1);
    }
}

TEST(Exact, SamplingEqualsPointEvaluation) {
    const ExactForce e =
        solve({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.02}, {duct, 0.004}, {bone, 0.01}});
    std::vector<double> force_n(1777);
    // The samples include the ends of the pieces and depths before and behind the path.
    for (const double first_m : {-0.001, 0.0, 0.01, 0.012 - 1e-12}) {
        const double step_m = 0.0001;
        sampleForce(e, first_m, step_m, force_n);
        for (std::size_t i = 0; i < force_n.size(); ++i)
            ASSERT_EQ(force_n[i], e.at(first_m + double(i) * step_m)) << i;
    }
    sampleForce({}, 0.0, 0.1, force_n);
    EXPECT_EQ(std::count(force_n.begin(), force_n.end(), 0.0), std::ptrdiff_t(force_n.size()));
}

// Changes of label alone do not split a tissue segment. The force stays bit-identical.
TEST(Exact, TissueChangesGiveTheSameForceAsLabelChanges) {
    patient::Package package =
        test::makeColumn({{skin, 0.002}, {soft, 0.01}, {fascia, 0.001}, {liver, 0.02}});
    const patient::TissueMap whole{patient::Patient(package)};
    patient::Label muscle = package.label_table[1];
    muscle.id = 77;
    package.label_table.push_back(muscle);
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i)
        if (package.labels.voxels[i] == muscle.id - 75 && i % 3 == 0) package.labels.voxels[i] = muscle.id;
    const patient::TissueMap parted{patient::Patient(package)};
    const Vec3 entry_m{-0.010, 0.0, 0.0}, end_m{0.030, 0.004, 0.003};
    const double length_m = glm::length(end_m - entry_m);
    VoxelPath path;
    const auto& walk = path.traverse(whole.grid(), entry_m, end_m);
    ExactSolver a(whole, {}), b(parted, {});
    b.solve(walk, length_m, Borders::labelChanges);
    EXPECT_GT(b.segments().size(), 6u);
    a.solve(walk, length_m, Borders::tissueChanges);
    const ExactForce expected = b.solve(walk, length_m, Borders::tissueChanges);
    EXPECT_EQ(a.segments().size(), 5u);
    EXPECT_EQ(b.segments().size(), 5u);
    for (double x_m = 0.0; x_m < length_m; x_m += 1e-5)
        ASSERT_EQ(a.solve(walk, length_m, Borders::tissueChanges).at(x_m), expected.at(x_m));
}

// A block of soft tissue, of voxels of 1 mm, and lines between voxel centres in it. A diagonal line runs
// exactly through edges or corners of voxels.
struct SoftBlock {
    patient::Package package = test::repeatColumn(test::makeColumn({{soft, 0.03}}, 0.001), 31, 0.001);
    const Grid grid = package.ct.grid;
    const Index3 entry = grid.nearest({0.0085, -0.007, -0.007});

    void paint(const Index3& beside, Tissue t) { package.labels[entry + beside] = std::uint8_t(t); }
    std::vector<Tissue> tissues(const Index3& from, const Index3& to, Borders borders) const {
        const patient::TissueMap map{patient::Patient(package)};
        const Vec3 from_m = grid.centre(from), to_m = grid.centre(to);
        VoxelPath path;
        std::vector<Segment> segments;
        segmentsAlong(map, path.traverse(grid, from_m, to_m), glm::length(to_m - from_m), borders, segments);
        std::vector<Tissue> out;
        for (const Segment& s : segments)
            out.push_back(s.tissue);
        return out;
    }
    std::vector<Tissue> alongEdges(Borders borders) const {
        return tissues(entry, entry + Index3(14, 14, 0), borders);
    }
    std::vector<Tissue> alongCorners() const {
        return tissues(entry, entry + Index3(14, 14, 14), Borders::tissueChanges);
    }
};

// The line only touches the two voxels beside it.
TEST(Exact, VoxelEdgesAreNotTissueChanges) {
    SoftBlock block;
    block.paint({7, 6, 0}, vessel), block.paint({6, 7, 0}, vessel);
    EXPECT_EQ(block.alongEdges(Borders::tissueChanges), (std::vector<Tissue>{soft}));
    EXPECT_EQ(block.alongEdges(Borders::labelChanges), (std::vector<Tissue>{soft, vessel, soft}));
}

// A membrane one voxel thick is closed across faces only: the line runs through the edge between two of its
// voxels. A line past the edge of a single voxel of a membrane does not cross it.
TEST(Exact, AMembraneIsCrossedAtTheEdgesOfItsVoxels) {
    for (const Tissue membrane : {fascia, skin}) {
        SoftBlock block;
        block.paint({7, 6, 0}, membrane);
        EXPECT_EQ(block.alongEdges(Borders::tissueChanges), (std::vector<Tissue>{soft}));
        block.paint({6, 7, 0}, membrane);
        EXPECT_EQ(block.alongEdges(Borders::tissueChanges), (std::vector<Tissue>{soft, membrane, soft}));
    }
    // Around a corner: the three voxels that share a face with the voxel before it. If one is missing, the
    // needle could pass there.
    SoftBlock block;
    block.paint({7, 6, 6}, fascia), block.paint({6, 7, 6}, fascia);
    EXPECT_EQ(block.alongCorners(), (std::vector<Tissue>{soft}));
    block.paint({6, 6, 7}, fascia);
    EXPECT_EQ(block.alongCorners(), (std::vector<Tissue>{soft, fascia, soft}));
}

// Behind the edge the needle is as far as if it had passed through the membrane's face.
TEST(Exact, AMembraneCrossedAtAnEdgeHasItsForce) {
    SoftBlock block;
    block.paint({7, 6, 0}, fascia), block.paint({6, 7, 0}, fascia);
    const patient::TissueMap map{patient::Patient(block.package)};
    const Vec3 from_m = block.grid.centre(block.entry),
               to_m = block.grid.centre(block.entry + Index3(14, 14, 0));
    VoxelPath path;
    ExactSolver solver(map, {});
    const ExactForce& e = solver.solve(path.traverse(block.grid, from_m, to_m), glm::length(to_m - from_m),
                                       Borders::tissueChanges);
    const ExactEvent cut = event(e, NeedleEventKind::puncture, fascia);
    EXPECT_NEAR(cut.border_depth_m, std::sqrt(2.0) * 0.0065, 1e-9);
    EXPECT_NEAR(cut.force_before_n, 2.5, 1e-9);
    EXPECT_NEAR(cut.force_after_n, 1.0, 1e-9);
}

// Membranes slanted in several directions, one voxel thick, and lines between voxel centres on both sides.
TEST(Exact, NoLineSlipsThroughASlantedMembrane) {
    for (const Index3& normal :
         {Index3(1, 1, 0), Index3(1, -1, 1), Index3(-3, 1, 0), Index3(3, 1, -2), Index3(-5, -3, -1)}) {
        SoftBlock block;
        const Index3 middle = block.grid.nearest({0.015, 0.0, 0.0});
        const Index3 sign(normal.x < 0 ? -1 : 1, normal.y < 0 ? -1 : 1, normal.z < 0 ? -1 : 1);
        const auto isInside = [&](const Index3& i) {
            return glm::dot(Vec3(normal), Vec3(i - middle)) > 0.25;
        };
        forEachVoxel(block.grid, [&](const Index3& i) {
            const bool in_front = isInside(i + Index3(sign.x, 0, 0)) || isInside(i + Index3(0, sign.y, 0)) ||
                                  isInside(i + Index3(0, 0, sign.z));
            if (block.package.labels[i] != 0)
                block.package.labels[i] = std::uint8_t(isInside(i) ? liver : in_front ? fascia : soft);
        });
        const Index3 outside = middle - 9 * sign;
        for (int x = 0; x < 6; ++x)
            for (int y = 0; y < 6; ++y)
                for (int z = 0; z < 6; ++z) {
                    SCOPED_TRACE(std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z));
                    const Index3 inside = middle + Index3(4 + x, 4 + y, 4 + z) * sign;
                    ASSERT_EQ(block.tissues(outside, inside, Borders::tissueChanges),
                              (std::vector<Tissue>{soft, fascia, liver}));
                    ASSERT_EQ(block.tissues(inside, outside, Borders::tissueChanges),
                              (std::vector<Tissue>{liver, fascia, soft}));
                }
    }
}

TEST(Exact, SegmentsFollowTheTrack) {
    // Unlabelled voxels of 250 HU count as bone in front of the fascia, and as contrast-filled vessel
    // (soft) behind it.
    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.01}, {fascia, 0.001}, {soft, 0.01}});
    for (const double x : {0.004, 0.020}) {
        const Index3 i = package.ct.grid.nearest({x, 0.0, 0.0});
        package.ct[i] = 250;
        package.labels[i] = 0;
    }
    VoxelPath path;
    std::vector<Segment> segments;
    const patient::TissueMap map{patient::Patient(package)};
    segmentsAlong(map, {-0.010, 0.0, 0.0}, {0.022, 0.0, 0.0}, path, segments);
    std::vector<Tissue> tissues;
    for (const Segment& s : segments)
        tissues.push_back(s.tissue);
    EXPECT_EQ(tissues, (std::vector<Tissue>{air, skin, soft, bone, soft, fascia, soft, soft, soft}));
    EXPECT_NEAR(segments[1].begin_m, 0.010, 1e-12);
    EXPECT_EQ(segments[7].label, 0);
}

}  // namespace
}  // namespace stylet::haptics
