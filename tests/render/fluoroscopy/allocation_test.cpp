// Counts allocations per picture after the first pictures, with a replaced operator new. There must be
// none.
#include <gtest/gtest.h>
#include <malloc.h>

#include "patient/contrast/contrast.h"
#include "render/fluoroscopy/fluoroscopy.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/support/counted_allocations.h"

namespace stylet::render {
namespace {

TEST(FluoroscopyAllocation, PicturesAllocateNothing) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    const patient::Package package = test::makeTrunk(0.004);
    const patient::Patient patient(package);
    Gpu gpu({});
    DeformedPatient deformed(gpu, patient);
    Fluoroscopy fluoroscopy(gpu, deformed);
    FluoroscopySettings settings;
    settings.pixels = 48;
    FluoroscopyInput input;
    std::vector<XrayShape> shapes;
    addNeedle({}, NeedleShape(), true, shapes);
    const patient::ContrastTable contrast{
        {Index3(4), package.ct.grid.spacing_m, package.ct.grid.centre({20, 20, 20})},
        std::vector<float>(64, 50.0f),
        1};
    input.contrast = &contrast;
    const auto pictures = [&](int count) {
        for (int i = 0; i < count; ++i) {
            deformed.breathe({.v = 0.1 * (i % 7)}, i % 7 == 0);
            input.pedal = i % 5 > 0;
            input.time_s += 0.1;
            input.arm.orbital_rad = 0.1 * (i % 3);
            shapes[0].begin_m.x = 0.001 * i;
            input.shapes = shapes;
            fluoroscopy.image(input, settings);
        }
    };
    pictures(35);
    const std::uint64_t before = test::allocations();
    const std::size_t held = mallinfo2().uordblks;
    pictures(35);
    EXPECT_EQ(test::allocations() - before, 0u);
    // The driver must not leak memory either. It once leaked 0.7 MB per picture (see rays.comp).
    EXPECT_LT(mallinfo2().uordblks, held + (1u << 20));
}

}  // namespace
}  // namespace stylet::render
