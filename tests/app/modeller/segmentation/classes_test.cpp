// Tests classes.json as a user may edit it.
#include "app/modeller/segmentation/classes.h"

#include <gtest/gtest.h>

#include "app/modeller/image/child_process_linux.h"

namespace stylet::modeller {
namespace {

const patient::Thresholds kMade{-610.0, -250.0, 160.0, 240.0};

std::string written() {
    return writeClasses({{-105.0, 9.0, 0.3}, {60.0, 9.0, 0.4}, {180.0, 12.0, 0.1}, {400.0, 90.0, 0.05}},
                        kMade);
}
std::string classesRefusal(const std::string& text) {
    try {
        parseClasses(text);
    } catch (const ImportError& e) {
        return e.what();
    }
    return "";
}
// The written text with one word replaced.
std::string with(const std::string& from, const std::string& to) {
    std::string text = written();
    return text.replace(text.find(from), from.size(), to);
}

TEST(Classes, ThresholdsAreReadAsWritten) {
    EXPECT_EQ(parseClasses(written()), kMade);
    EXPECT_EQ(parseClasses(with("160.0", "175.5")).t2_sensitive_hu, 175.5);
}

TEST(Classes, WhatIsNoThresholdIsNamed) {
    EXPECT_NE(classesRefusal("").find("classes.json: "), std::string::npos);
    EXPECT_NE(classesRefusal("[]").find("classes.json: "), std::string::npos);
    EXPECT_NE(classesRefusal(with("\"t1\"", "\"t9\"")).find("t1"), std::string::npos);
    EXPECT_NE(classesRefusal(with("160.0", "\"hard\"")).find("classes.json: "), std::string::npos);
    EXPECT_NE(classesRefusal(with("160.0", "1e300")).find("t2_sensitive: 1e+300 is not in"),
              std::string::npos);
    EXPECT_NE(classesRefusal(with("160.0", "-900")).find("does not hold"), std::string::npos);
    EXPECT_NE(classesRefusal(with("240.0", "150")).find("does not hold"), std::string::npos);
}

}  // namespace
}  // namespace stylet::modeller
