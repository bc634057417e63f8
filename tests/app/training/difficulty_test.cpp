#include "app/training/difficulty.h"

#include <gtest/gtest.h>

#include "tests/app/trainer/difficulties.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"

namespace stylet::training {
namespace {

TEST(Difficulty, ExamShowsOnlyTheRoom) {
    const DifficultyRules& exam = test::difficulties()[Difficulty::exam];
    for (const bool shown : {exam.panel, exam.next_step, exam.path, exam.colours, exam.cues, exam.slices,
                             exam.open_look, exam.home, exam.snap, exam.expert})
        EXPECT_FALSE(shown);
    EXPECT_EQ(exam.start, StartPlace::room);
    EXPECT_TRUE(test::difficulties()[Difficulty::guided].next_step);
    EXPECT_FALSE(test::difficulties()[Difficulty::practice].next_step);
}

// HZ-TEACH-12
TEST(Difficulty, WithoutATableEveryDifficultyIsStrict) {
    const DifficultyTable table;
    for (const Difficulty difficulty : {Difficulty::guided, Difficulty::practice, Difficulty::exam}) {
        const DifficultyRules& rules = table[difficulty];
        for (const bool shown : {rules.panel, rules.next_step, rules.path, rules.colours, rules.cues,
                                 rules.slices, rules.open_look, rules.home, rules.snap, rules.expert})
            EXPECT_FALSE(shown);
        EXPECT_EQ(rules.start, StartPlace::room);
    }
}

// The shipped table with one text replaced is refused, and the error names the field.
void expectRefused(const std::string& from, const std::string& to, const std::string& field) {
    std::string toml = test::readText(test::assets() / "difficulty.toml");
    const std::size_t at = toml.rfind(from);
    ASSERT_NE(at, std::string::npos) << from;
    toml.replace(at, from.size(), to);
    test::expectRefused([&] { parseDifficulties(toml, "table.toml"); }, "table.toml", field);
}

TEST(Difficulty, TableThatMakesNoSenseIsRefused) {
    expectRefused("path = false", "path = true", "exam.path: an easier difficulty forbids it");
    expectRefused("start = \"room\"", "start = \"roof\"", "exam.start");
    expectRefused("home = false", "", "exam.home: missing");
    expectRefused("home = false", "home = 0", "exam.home");
    expectRefused("home = false", "home = false\nhelp = true", "exam.help");
    expectRefused("[exam]", "[test]", "exam: missing");
}

}  // namespace
}  // namespace stylet::training
