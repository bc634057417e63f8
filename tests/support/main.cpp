// main() of every test program. With STYLET_FORBID_SKIPS set, a skipped test counts as a failure.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    testing::InitGoogleMock(&argc, argv);
    const int result = RUN_ALL_TESTS();
    const int skipped = testing::UnitTest::GetInstance()->skipped_test_count();
    if (result == 0 && skipped > 0 && std::getenv("STYLET_FORBID_SKIPS") != nullptr) {
        std::fprintf(stderr, "%d tests were skipped, and STYLET_FORBID_SKIPS is set\n", skipped);
        return 1;
    }
    return result;
}
