// Replaces operator new to count allocations while frames update the tool displacement. There must be none.
#include <gtest/gtest.h>

#include "patient/displacement/tool_displacement.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

TEST(ToolDisplacementAllocation, FramesAllocateNothing) {
    Package package = test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.030}}, 0.001);
    package.motion = test::makeShift(0.020);
    const Patient patient(package);
    ToolDisplacement tool(patient);
    const std::uint64_t before = test::allocations();
    for (int frame = 0; frame < 60; ++frame) {
        // Presses in and out, moves elsewhere, then leaves. The patient breathes all the time.
        ToolContact contact;
        contact.begin_m.y = contact.end_m.y = frame < 30 ? 0.0 : 0.1;
        contact.begin_moved_m.x = contact.end_moved_m.x = 0.0002 * (frame % 20);
        tool.update({&contact, frame < 50 ? 1u : 0u}, {0.02 * frame, 0.0}, 1.0 / 90.0);
    }
    EXPECT_EQ(test::allocations(), before);
    ::operator delete(::operator new(4));
    EXPECT_GT(test::allocations(), before);
}

}  // namespace
}  // namespace stylet::patient
