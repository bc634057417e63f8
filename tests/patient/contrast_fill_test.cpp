#include "patient/contrast/contrast_fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stylet::patient {
namespace {

// A tube of slices 1 mm thick, with a volume of 1 mm^3 each.
struct Tube {
    std::vector<double> path_m, capacity_m3;
    explicit Tube(int slices) {
        for (int i = 0; i < slices; ++i)
            path_m.push_back(1e-3 * i), capacity_m3.push_back(1e-9);
    }
    double filled(const FrontShape& shape, double front_m) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < path_m.size(); ++i)
            sum += capacity_m3[i] * shape.share(front_m, path_m[i]);
        return sum;
    }
};

TEST(FillOrder, FilledVolumeIsTheSumOfTheShares) {
    const Tube tube(50);
    const FillOrder order(tube.path_m, tube.capacity_m3);
    for (const FrontShape shape : {FrontShape{0.002, 0.0}, FrontShape{0.004, 0.3}, FrontShape{0.001, 1.5}})
        for (double front_m = -0.001; front_m < 0.2; front_m += 0.0007)
            EXPECT_NEAR(order.filled(shape, front_m), tube.filled(shape, front_m), 1e-20) << front_m;
}

TEST(FillOrder, FrontPositionMatchesTheFilledVolume) {
    const Tube tube(50);
    const FillOrder order(tube.path_m, tube.capacity_m3);
    const FrontShape sharp{0.002, 0.0};
    // Distances refer to voxel centres: the first slice starts half a millimetre before the first centre.
    for (const double slices : {2.0, 10.0, 33.3, 48.0})
        EXPECT_NEAR(order.frontPosition_m(sharp, slices * 1e-9), (slices - 0.5) * 1e-3, 1e-9);
    for (const FrontShape shape : {sharp, FrontShape{0.002, 0.1}, FrontShape{0.003, 1.9}})
        for (double share = 0.0; share <= 1.0; share += 0.01)
            EXPECT_NEAR(order.filled(shape, order.frontPosition_m(shape, share * 50e-9)), share * 50e-9,
                        1e-17);
    EXPECT_NEAR(order.total(), 50e-9, 1e-20);
}

TEST(FillOrder, UnreachableVoxelsAreIgnored) {
    const std::vector<double> way{0.0, std::numeric_limits<double>::infinity(), 0.001, NAN};
    const std::vector<double> room{1e-9, 1e-9, 0.0, 1e-9};
    EXPECT_DOUBLE_EQ(FillOrder(way, room).total(), 1e-9);
    const FillOrder none;
    EXPECT_EQ(none.total(), 0.0);
    EXPECT_EQ(none.frontPosition_m({}, 1e-6), 0.0);
}

}  // namespace
}  // namespace stylet::patient
