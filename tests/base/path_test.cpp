#include "base/path.h"

#include <gtest/gtest.h>

namespace stylet {
namespace {

TEST(Path, ASlashAtTheEndChangesNothing) {
    for (const char* folder : {"a/b", "/a/b", "a", "..", "/"})
        EXPECT_EQ(withoutSlash(folder), folder);
    EXPECT_EQ(withoutSlash("a/b/"), "a/b");
    EXPECT_EQ(withoutSlash("a/b//"), "a/b");
    EXPECT_EQ(withoutSlash("/a/"), "/a");
    EXPECT_EQ(withoutSlash(""), "");
}

}  // namespace
}  // namespace stylet
