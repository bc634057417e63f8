#include "haptics/devices/permission_linux.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace stylet::haptics {
namespace {

TEST(Permission, EveryRefusalNamesTheNodeAndItsRemedy) {
    EXPECT_NE(accessProblem("/dev/hidraw7", EACCES).find("udevadm control --reload"), std::string::npos);
    EXPECT_NE(accessProblem("/dev/hidraw7", EBUSY).find("close the other program"), std::string::npos);
    EXPECT_NE(accessProblem("/dev/hidraw7", ENODEV).find("plug the device in again"), std::string::npos);
    for (const int error : {EACCES, EPERM, EBUSY, ENOENT, ENODEV, EIO, 0})
        EXPECT_NE(accessProblem("/dev/hidraw7", error).find("/dev/hidraw7"), std::string::npos) << error;
}

TEST(Permission, NodeIsCheckedWithoutOpeningIt) {
    const test::TempFolder folder;
    const std::string node = folder / "node";
    EXPECT_NE(accessProblem(node).find("is gone"), std::string::npos);
    std::ofstream(node) << "x";
    EXPECT_EQ(accessProblem(node), "");
    if (geteuid() != 0) {
        chmod(node.c_str(), 0);
        EXPECT_NE(accessProblem(node).find("no permission"), std::string::npos);
        return;
    }
    // Root may open any file, so drop to the user nobody.
    chmod(node.c_str(), 0600);
    chmod(folder.path().c_str(), 0755);
    constexpr uid_t kNobody = 65534;
    ASSERT_EQ(setresuid(kNobody, 0, 0), 0);
    const std::string problem = accessProblem(node);
    ASSERT_EQ(setresuid(0, 0, 0), 0);
    EXPECT_NE(problem.find("no permission for " + node), std::string::npos) << problem;
}

}  // namespace
}  // namespace stylet::haptics
