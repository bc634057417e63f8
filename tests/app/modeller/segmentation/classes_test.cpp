// Tests classes.json as a user may edit it.
#include "app/modeller/segmentation/classes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/errors.h"
#include "tests/support/refused.h"

namespace stylet::modeller {
namespace {

const patient::Thresholds kMade{-610.0, -250.0, 160.0, 240.0};

std::string classesText() {
    return writeClasses({{-105.0, 9.0, 0.3}, {60.0, 9.0, 0.4}, {180.0, 12.0, 0.1}, {400.0, 90.0, 0.05}},
                        kMade);
}
std::string classesRefusal(const std::string& text) {
    return test::errorText<DataError>([&] { parseClasses(text); });
}
// The written text with one word replaced.
std::string replaced(const std::string& from, const std::string& to) {
    std::string text = classesText();
    return text.replace(text.find(from), from.size(), to);
}

TEST(Classes, ThresholdsSurviveARoundTrip) {
    EXPECT_EQ(parseClasses(classesText()), kMade);
    EXPECT_EQ(parseClasses(replaced("160.0", "175.5")).t2_sensitive_hu, 175.5);
}

TEST(Classes, InvalidThresholdsAreNamed) {
    EXPECT_THAT(classesRefusal(""), testing::HasSubstr("classes.json: "));
    EXPECT_THAT(classesRefusal("[]"), testing::HasSubstr("classes.json: "));
    EXPECT_THAT(classesRefusal(replaced("\"t1\"", "\"t9\"")), testing::HasSubstr("t1"));
    EXPECT_THAT(classesRefusal(replaced("160.0", "\"hard\"")), testing::HasSubstr("classes.json: "));
    EXPECT_THAT(classesRefusal(replaced("160.0", "1e300")),
                testing::HasSubstr("t2_sensitive: 1e+300 is not in"));
    EXPECT_THAT(classesRefusal(replaced("160.0", "-900")), testing::HasSubstr("does not hold"));
    EXPECT_THAT(classesRefusal(replaced("240.0", "150")), testing::HasSubstr("does not hold"));
}

}  // namespace
}  // namespace stylet::modeller
