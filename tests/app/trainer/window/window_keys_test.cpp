#include "app/trainer/window/window_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/app/trainer/difficulties.h"

namespace stylet::trainer {
namespace {

using training::Difficulty;

KeyPress function(int number) {
    KeyPress press;
    press.key = char(kKeyF1 + number - 1);
    return press;
}

// The key starts from the attempt's current difficulty, no matter who set it, and cycles through all levels.
TEST(WindowKeys, F12SetsTheNextDifficulty) {
    const auto port = std::make_shared<WindowPort>();
    WindowKeys keys(port);
    keys.setState(false, false, Difficulty::exam);
    keys.press(function(12));
    keys.setState(false, false, Difficulty::exam);  // a state from before the key press
    keys.press(function(12));
    keys.press(function(12));
    EXPECT_EQ(port->typed(), "difficulty guided\ndifficulty practice\ndifficulty exam\n");
    for (int i = 0; i < 10; ++i)
        keys.setState(false, false, Difficulty::practice);
    keys.press(function(12));
    EXPECT_EQ(port->typed(), "difficulty exam\n");
}

KeyPress typed(const std::string& text) {
    KeyPress press;
    press.text = text;
    return press;
}
KeyPress key(char which) {
    KeyPress press;
    press.key = which;
    return press;
}

// A mouse has no force to re-arm: neither the key nor its help exist.
TEST(WindowKeys, EnterReArmsOnlyAHapticDevice) {
    for (const bool haptic : {false, true}) {
        const auto port = std::make_shared<WindowPort>();
        haptic ? port->enableCommands() : port->enableToolInput();
        if (haptic) port->enableRearm();
        WindowKeys keys(port);
        keys.press(key(kKeyEnter));
        EXPECT_EQ(port->typed(), haptic ? "rearm\n" : "");
        bool helps = false;
        for (const auto& row : keys.rows(test::difficulties()[Difficulty::guided]))
            for (const WindowKeys::Help& help : row)
                helps = helps || help.key == "Enter" || help.what.find("re-arm") != std::string::npos;
        EXPECT_EQ(helps, haptic);
    }
}

// The key T places the mouse's tool on the skin. A haptic device cannot be placed. In an exam nothing is
// offered, and the session refuses the request (snap_test.cpp).
TEST(WindowKeys, TPlacesTheToolOfAMouse) {
    for (const bool mouse : {false, true}) {
        const auto port = std::make_shared<WindowPort>();
        mouse ? port->enableToolInput() : port->enableCommands();
        WindowKeys keys(port);
        keys.press(key('t'));
        EXPECT_EQ(port->typed(), mouse ? "skin\n" : "");
        for (const Difficulty difficulty : {Difficulty::guided, Difficulty::practice, Difficulty::exam}) {
            bool helps = false;
            for (const auto& row : keys.rows(test::difficulties()[difficulty]))
                for (const WindowKeys::Help& help : row)
                    helps = helps || help.key == "T";
            EXPECT_EQ(helps, mouse && difficulty != Difficulty::exam);
        }
    }
}

// One syringe at a time: each key stops either.
TEST(WindowKeys, InjectionKeysStartAndStop) {
    const auto port = std::make_shared<WindowPort>();
    port->enableCommands();
    WindowKeys keys(port);
    keys.setCourse(training::Course::drainage);
    for (const char which : {'m', 'i'})
        keys.press(key(which));
    EXPECT_EQ(port->typed(), "numb or stop\ninject or stop\n");
}

// A puncture has no local anaesthesia: neither the key nor its help exist.
TEST(WindowKeys, MNumbsOnlyInADrainage) {
    for (const training::Course course : {training::Course::puncture, training::Course::drainage}) {
        const bool drainage = course == training::Course::drainage;
        const auto port = std::make_shared<WindowPort>();
        port->enableToolInput();
        WindowKeys keys(port);
        keys.setCourse(course);
        keys.press(key('m'));
        EXPECT_EQ(port->typed(), drainage ? "numb or stop\n" : "");
        keys.press(key('i'));
        EXPECT_EQ(port->typed(), "inject or stop\n");
        int helps = 0;
        for (const auto& row : keys.rows(test::difficulties()[Difficulty::guided]))
            for (const WindowKeys::Help& help : row)
                helps += help.key == "M" || help.what.find("numb") != std::string::npos;
        EXPECT_EQ(helps, drainage ? 1 : 0);
    }
}

TEST(WindowKeys, YAndUAnswerOnlyInADrainage) {
    for (const training::Course course : {training::Course::puncture, training::Course::drainage}) {
        const auto port = std::make_shared<WindowPort>();
        port->enableCommands();
        WindowKeys keys(port);
        keys.setCourse(course);
        keys.press(key('y')), keys.press(key('u'));
        EXPECT_EQ(port->typed(), course == training::Course::drainage ? "yes\nno\n" : "");
    }
}

TEST(WindowKeys, F1EntersACommandAndF9AComment) {
    const auto port = std::make_shared<WindowPort>();
    WindowKeys keys(port);
    keys.press(function(1));
    EXPECT_TRUE(keys.isTyping());
    keys.press(typed("new seed 7"));
    EXPECT_NE(keys.state().find("command: new seed 7"), std::string::npos);
    keys.press(key(kKeyEnter));
    keys.press(function(9));
    keys.press(typed("cough"));
    keys.press(key(kKeyEnter));
    keys.press(function(1));
    keys.press(typed("retry"));
    keys.press(key(kKeyEscape));
    EXPECT_EQ(port->typed(), "new seed 7\ncomment cough\n");
}

// Wheel and Page keys move the tool along its axis. desktop_run_test.cpp turns the wheel.
TEST(WindowKeys, TheHelpNamesTheDirectionsOfTheWheel) {
    const auto port = std::make_shared<WindowPort>();
    port->enableToolInput();
    std::string in, out;
    for (const auto& row : WindowKeys(port).rows(test::difficulties()[Difficulty::guided]))
        for (const WindowKeys::Help& help : row)
            if (help.what == "in")
                in = help.key;
            else if (help.what == "out")
                out = help.key;
    EXPECT_EQ(in, "wheel forward (away from you), Page Down");
    EXPECT_EQ(out, "wheel back, Page Up");
}

TEST(WindowKeys, RowsAreSplitBetweenEntriesToFitTheWindow) {
    const auto port = std::make_shared<WindowPort>();
    port->enableToolInput();
    WindowKeys keys(port);
    keys.setCourse(training::Course::drainage);
    const WindowKeys::HelpRows rows = keys.rows(test::difficulties()[Difficulty::guided]);
    const auto entry_px = [](const WindowKeys::Help& help) {
        return 8.0 * double(help.key.size() + help.what.size() + 2);
    };
    const auto flat = [](const WindowKeys::HelpRows& all) {
        std::vector<WindowKeys::Help> entries;
        for (const auto& row : all)
            entries.insert(entries.end(), row.begin(), row.end());
        return entries;
    };
    for (const double width_px : {1280.0, 720.0, 500.0}) {
        const WindowKeys::HelpRows split = splitRows(rows, width_px, entry_px);
        EXPECT_EQ(flat(split), flat(rows)) << "every key, in order";
        for (const auto& row : split) {
            double sum_px = 0.0;
            for (const WindowKeys::Help& help : row)
                sum_px += entry_px(help);
            EXPECT_LE(sum_px, width_px);
        }
    }
    EXPECT_EQ(splitRows(rows, 1e6, entry_px), rows);
    EXPECT_EQ(splitRows({{{"F1", "command"}}}, 1.0, entry_px).size(), 1u) << "an entry is never split";
}

// Small windows, in which not all rows have space.
TEST(WindowKeys, KeysThatDoNotFitAreOnFurtherPages) {
    const auto port = std::make_shared<WindowPort>();
    port->enableToolInput();
    WindowKeys keys(port);
    keys.setCourse(training::Course::drainage);
    const WindowKeys::HelpRows rows = keys.rows(test::difficulties()[Difficulty::guided]);
    EXPECT_EQ(rows[0][0].what, "move") << "the trainee's keys come first";
    EXPECT_EQ(rows.back()[0].key, "Instructor");
    const auto entry_px = [](const WindowKeys::Help& help) {
        return 7.0 * double(help.key.size() + help.what.size() + 2);
    };
    EXPECT_EQ(fitRows(rows, 1256.0, 9, 1, entry_px), splitRows(rows, 1256.0, entry_px)) << "all fit";
    const int needed = int(splitRows(rows, 776.0, entry_px).size());
    EXPECT_NE(fitRows(rows, 776.0, needed - 1, 0, entry_px).back().back().key, "J") << "closer together";
    for (const auto& [width_px, max_rows] : {std::pair{616.0, 5}, {616.0, 3}, {296.0, 1}}) {
        std::set<std::string> missing;
        for (const auto& row : rows)
            for (const WindowKeys::Help& help : row)
                missing.insert(help.key);
        const WindowKeys::HelpRows first = fitRows(rows, width_px, max_rows, 0, entry_px);
        int page = 0;
        do {
            const WindowKeys::HelpRows shown = fitRows(rows, width_px, max_rows, page, entry_px);
            EXPECT_EQ(int(shown.size()), max_rows) << page;
            EXPECT_EQ(shown.back().back(), (WindowKeys::Help{"J", "more keys"})) << page;
            for (const auto& row : shown)
                for (const WindowKeys::Help& help : row)
                    missing.erase(help.key);
        } while (fitRows(rows, width_px, max_rows, ++page, entry_px) != first && page < 30);
        EXPECT_THAT(missing, testing::IsEmpty());
        EXPECT_GT(page, 1);
    }
}

TEST(WindowKeys, F8SetsABookmark) {
    const auto port = std::make_shared<WindowPort>();
    WindowKeys keys(port);
    keys.press(function(8));
    EXPECT_EQ(port->typed(), "bookmark\n");
}

}  // namespace
}  // namespace stylet::trainer
