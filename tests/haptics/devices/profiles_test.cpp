#include "haptics/devices/profiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "haptics/haptics.h"

namespace stylet::haptics {
namespace {

TEST(DeviceProfiles, MatchTheSharedTable) {
    struct Known {
        const char* name;
        double force_n, stiffness_n_per_m;
    };
    for (const Known& k :
         {Known{"paper", 22.0, 1000.0}, Known{"touch", 3.3, 400.0}, Known{"touch-x", 7.9, 1000.0},
          Known{"premium-1.5", 8.5, 800.0}, Known{"premium-3.0", 22.0, 1000.0}, Known{"falcon", 8.0, 3000.0},
          Known{"omega.3", 12.0, 5000.0}, Known{"sigma.7", 12.0, 4000.0}}) {
        const DeviceProfile* p = findProfile(k.name);
        ASSERT_NE(p, nullptr) << k.name;
        EXPECT_EQ(p->force_peak_n, k.force_n) << k.name;
        EXPECT_EQ(p->stiffness_n_per_m, k.stiffness_n_per_m) << k.name;
    }
    EXPECT_EQ(findProfile("touch")->force_continuous_n, 0.88);
    EXPECT_EQ(findProfile("touch-x")->force_continuous_n, 1.75);
    EXPECT_EQ(findProfile("no such device"), nullptr);
}

TEST(DeviceProfiles, AreCitedAndPlausible) {
    std::set<std::string> names;
    const auto unknownOr = [](double value, double low, double high) {
        return std::isnan(value) || (value > low && value < high);
    };
    for (const DeviceProfile& p : deviceProfiles()) {
        EXPECT_TRUE(names.insert(p.name).second) << p.name << " is there twice";
        EXPECT_GT(std::strlen(p.source), 10u) << p.name;
        EXPECT_TRUE(unknownOr(p.force_peak_n, 1.0, 40.0)) << p.name;
        EXPECT_TRUE(unknownOr(p.stiffness_n_per_m, 100.0, 20000.0)) << p.name;
        EXPECT_TRUE(unknownOr(p.mass_kg, 0.01, 1.0)) << p.name;
        // Rendered damping is tens of N s/m. This field is the device's own damping.
        EXPECT_TRUE(unknownOr(p.damping_n_s_per_m, 0.0, 1.0)) << p.name;
        EXPECT_TRUE(unknownOr(p.resolution_m, 0.0, 2e-4)) << p.name;
        const double gain = outputGain(p, {});
        EXPECT_TRUE(gain > 0.0 && gain <= 1.0) << p.name;
    }
}

}  // namespace
}  // namespace stylet::haptics
