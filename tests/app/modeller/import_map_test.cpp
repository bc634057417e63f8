#include "app/modeller/import/import_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <stdexcept>

#include "base/errors.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

std::string mapRefusal(const std::string& text) {
    test::TempFolder temp;
    std::ofstream(temp / "map.csv") << text;
    return test::errorText<DataError>([&] { loadLabelMap(temp / "map.csv"); });
}

TEST(ImportMap, TargetIdsAreConsecutiveAndNamesUnique) {
    std::set<std::string> names;
    int id = 0;
    for (const patient::Label& l : targetTable()) {
        EXPECT_EQ(l.id, ++id);
        EXPECT_TRUE(names.insert(l.name).second) << l.name;
    }
    for (const char* name : {"liver", "bile ducts", "portal vein", "hepatic veins", "skin", "fascia", "bone"})
        EXPECT_NE(findTarget(name), nullptr) << name;
}

// An import and a build copy the targets' roles into the package.
TEST(ImportMap, TargetsHaveConsistentRoles) {
    for (const patient::Label& l : targetTable())
        EXPECT_FALSE(patient::findRoleConflict(l)) << l.name << ": " << patient::findRoleConflict(l)->reason;
    EXPECT_EQ(findTarget("portal vein")->blood, patient::BloodKind::portal);
    EXPECT_EQ(findTarget("heart")->structure, patient::Structure::heart);
    EXPECT_TRUE(findTarget("tumour")->blocks_contrast);
    EXPECT_TRUE(findTarget("small bowel")->drains_ducts);
}

TEST(ImportMap, ReadsIdsCommentsAndKeys) {
    test::TempFolder temp;
    std::ofstream(temp / "map.csv") << "# source: Clinic\r\n# licence: CC0\r\n# other\r\n\r\n"
                                       "source_id,tissue\r\n1, liver\r\n 513 ,unsegmented\r\n";
    const LabelMap map = loadLabelMap(temp / "map.csv");
    EXPECT_EQ(map.source, "Clinic");
    EXPECT_EQ(map.licence, "CC0");
    ASSERT_EQ(map.target_of.size(), 2u);
    EXPECT_EQ(map.target_of.at(1), targetId("liver"));
    EXPECT_EQ(map.target_of.at(513), 0);
}

TEST(ImportMap, ErrorsNameTheLine) {
    EXPECT_THAT(mapRefusal("source_id,tissue\n1,liver\n2,lever\n"),
                testing::HasSubstr("line 3: there is no target \"lever\""));
    EXPECT_THAT(mapRefusal("source_id,tissue\n1,liver\n1,bone\n"),
                testing::HasSubstr("line 3: source_id 1 is mapped twice"));
    EXPECT_THAT(mapRefusal("source_id,tissue\n-4,liver\n"), testing::HasSubstr("line 2"));
    EXPECT_THAT(mapRefusal("source_id,tissue\n1e3,liver\n"), testing::HasSubstr("not a whole number"));
    EXPECT_THAT(mapRefusal("source_id,tissue\nliver\n"), testing::HasSubstr("two fields"));
    EXPECT_THAT(mapRefusal("1,liver\n"), testing::HasSubstr("the header must be \"source_id,tissue\""));
    EXPECT_THAT(mapRefusal("source_id,tissue\n1," + std::string(1000, 'x')),
                testing::HasSubstr("line 2: too long"));
    EXPECT_THAT(mapRefusal(std::string((1 << 20) + 1, '#')),
                testing::HasSubstr("map.csv: file: larger than 1048576 bytes"));
    EXPECT_THAT(mapRefusal(""), testing::HasSubstr("maps nothing"));
}

TEST(ImportMap, SpreadsheetFilesAreReadOrExplained) {
    const std::filesystem::path file = "map.csv";
    for (const char* text : {"\xEF\xBB\xBFsource_id,tissue\r\n7,liver\r\n", "source_id,tissue\r7,liver\r",
                             "\xEF\xBB\xBF# source: J\xC3\xBCrgen\rsource_id,tissue\r7,liver"})
        EXPECT_EQ(parseLabelMap(file, text).target_of.size(), 1u) << text;
    EXPECT_THAT(mapRefusal("#\n\nsource_id;tissue\n7;liver\n"),
                testing::EndsWith("line 3: the header must be \"source_id,tissue\", separated by a comma; it "
                                  "is \"source_id;tissue\""));
    EXPECT_THAT(mapRefusal("source_id\ttissue\n"), testing::HasSubstr("separated by a comma"));
    EXPECT_THAT(mapRefusal("# source: J\xFCrgen\nsource_id,tissue\n7,liver\n"),
                testing::HasSubstr("map.csv: line 1: not UTF-8"));
}

TEST(ImportMap, TheBackgroundIsNoTissue) {
    EXPECT_THAT(mapRefusal("source_id,tissue\n7,liver\n0,liver\n"),
                testing::HasSubstr("line 3: source_id 0 is the background"));
    EXPECT_EQ(mapRefusal("source_id,tissue\n7,liver\n0,unsegmented\n"), "");
}

}  // namespace
}  // namespace stylet::modeller
