#include "app/modeller/import/import_map.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <stdexcept>

#include "app/modeller/image/import_image.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

std::string mapRefusal(const std::string& text) {
    test::TempFolder temp;
    std::ofstream(temp / "map.csv") << text;
    try {
        loadLabelMap(temp / "map.csv");
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return "";
}

TEST(ImportMap, TargetsHaveIdsInOrderAndNamesOnce) {
    std::set<std::string> names;
    int id = 0;
    for (const patient::Label& l : targetTable()) {
        EXPECT_EQ(l.id, ++id);
        EXPECT_TRUE(names.insert(l.name).second) << l.name;
    }
    for (const char* name : {"liver", "bile ducts", "portal vein", "hepatic veins", "skin", "fascia", "bone"})
        EXPECT_NE(findTarget(name), nullptr) << name;
}

TEST(ImportMap, ReadsIdsCommentsAndKeys) {
    test::TempFolder temp;
    std::ofstream(temp / "map.csv") << "# source: Clinic\r\n# licence: CC0\r\n# other\r\n\r\n"
                                       "source_id,tissue\r\n1, liver\r\n 513 ,unsegmented\r\n";
    const LabelMap map = loadLabelMap(temp / "map.csv");
    EXPECT_EQ(map.source, "Clinic");
    EXPECT_EQ(map.licence, "CC0");
    ASSERT_EQ(map.target_of.size(), 2u);
    EXPECT_EQ(map.target_of.at(1), findTarget("liver")->id);
    EXPECT_EQ(map.target_of.at(513), 0);
}

TEST(ImportMap, RefusesByLine) {
    EXPECT_NE(mapRefusal("source_id,tissue\n1,liver\n2,lever\n").find("line 3: there is no target \"lever\""),
              std::string::npos);
    EXPECT_NE(mapRefusal("source_id,tissue\n1,liver\n1,bone\n").find("line 3: source_id 1 is mapped twice"),
              std::string::npos);
    EXPECT_NE(mapRefusal("source_id,tissue\n-4,liver\n").find("line 2"), std::string::npos);
    EXPECT_NE(mapRefusal("source_id,tissue\n1e3,liver\n").find("not a whole number"), std::string::npos);
    EXPECT_NE(mapRefusal("source_id,tissue\nliver\n").find("two fields"), std::string::npos);
    EXPECT_NE(mapRefusal("1,liver\n").find("the first line must be"), std::string::npos);
    EXPECT_NE(mapRefusal("source_id,tissue\n1," + std::string(1000, 'x')).find("line 2: too long"),
              std::string::npos);
    EXPECT_NE(mapRefusal(std::string((1 << 20) + 1, '#')).find("map.csv: file: larger than 1048576 bytes"),
              std::string::npos);
    EXPECT_NE(mapRefusal("").find("maps nothing"), std::string::npos);
}

}  // namespace
}  // namespace stylet::modeller
