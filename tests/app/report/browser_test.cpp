// Opens the pages in headless Chromium. Checks that there are no console errors and no network requests,
// that figures are drawn, that elements have accessible names, and that the keyboard alone is enough.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "app/report/attempt_page.h"
#include "app/report/group_pages.h"
#include "base/whole_file.h"
#include "tests/app/report/attempt_folder.h"
#include "tests/support/browser.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace stylet::report;
using stylet::test::Browser;

// The pages are created once. One browser serves all tests because it takes seconds to start.
class Pages : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new stylet::test::TempFolder;
        const std::filesystem::path attempt = *folder_ / "attempt";
        const auto cohort = stylet::test::makeTestCohort();
        stylet::test::writeAttemptFolder(attempt, 60000, cohort[8]);
        AttemptContext context;
        context.cohort = cohort;
        stylet::writeWholeFile(*folder_ / "attempt.html", attemptReport(loadAttempt(attempt), context).html);
        std::vector<stylet::records::StoredAttempt> own;
        for (const auto& a : cohort)
            if (a.info.trainee == "trainee-F") own.push_back(a);
        stylet::writeWholeFile(*folder_ / "trainee.html", traineeReport("trainee-F", own, cohort).html);
        stylet::writeWholeFile(*folder_ / "cohort.html", cohortReport("Scenario procedure", cohort).html);
        browser_ = new Browser;
    }
    static void TearDownTestSuite() {
        delete browser_;
        delete folder_;
    }

    // Saves a screenshot if STYLET_SHOTS names a folder.
    static void saveScreenshot(const std::string& name) {
        if (const char* shots = std::getenv("STYLET_SHOTS"))
            browser_->screenshot(std::filesystem::path(shots) / (name + ".png"));
    }

    static stylet::test::TempFolder* folder_;
    static Browser* browser_;
};
stylet::test::TempFolder* Pages::folder_ = nullptr;
Browser* Pages::browser_ = nullptr;

constexpr const char* kPages[] = {"attempt", "trainee", "cohort"};

TEST_F(Pages, DrawWithoutErrorsOrNetwork) {
    for (const std::string page : kPages)
        for (const int width : {1280, 400}) {
            browser_->open(*folder_ / (page + ".html"), width, 900);
            saveScreenshot(page + "-" + std::to_string(width));
            EXPECT_EQ(browser_->complaints(), std::vector<std::string>{}) << page;
            for (const std::string& address : browser_->requests())
                EXPECT_TRUE(address.starts_with("file://") || address.starts_with("data:")) << address;
            // No canvas is blank: each has more than 300 opaque pixels and more than two colours.
            const auto drawn =
                browser_->evaluate(R"(Array.from(document.querySelectorAll('canvas')).map(c => {
                const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data, seen = new Set();
                let ink = 0;
                for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) { ++ink; seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]); }
                return ink > 300 && seen.size > 2;
            }))");
            EXPECT_GE(drawn.size(), 1u) << page;
            for (const auto& one : drawn)
                EXPECT_EQ(one, true) << page << " at " << width;
            // The page itself does not scroll sideways.
            EXPECT_LE(browser_->evaluate("document.scrollingElement.scrollWidth").get<int>(), width) << page;
            // Every link leads to a place on the page.
            EXPECT_EQ(browser_->evaluate("Array.from(document.querySelectorAll('a')).filter(a => "
                                         "!document.getElementById(a.hash.slice(1))).length"),
                      0)
                << page;
        }
}

TEST_F(Pages, ElementsHaveAccessibleNames) {
    for (const std::string page : kPages) {
        browser_->open(*folder_ / (page + ".html"), 1280, 900);
        std::multiset<std::string> roles;
        for (const Browser::Accessible& a : browser_->accessibles()) {
            roles.insert(a.role);
            for (const char* role :
                 {"image", "img", "table", "button", "combobox", "link", "region", "navigation", "heading"})
                EXPECT_TRUE(a.role != role || !a.name.empty()) << page << ": a nameless " << role;
        }
        EXPECT_GE(roles.count("table"), 1u) << page;
        EXPECT_GE(roles.count("heading"), 3u) << page;
        EXPECT_EQ(roles.count("main"), 1u) << page;
        EXPECT_EQ(browser_->evaluate("document.documentElement.lang"), "en");
        EXPECT_EQ(browser_->evaluate("document.querySelectorAll('h1').length"), 1);
        EXPECT_NE(browser_->evaluate("document.title"), "");
        EXPECT_EQ(browser_->evaluate("Array.from(document.images).every(i => i.alt && i.naturalWidth > 0)"),
                  true);
    }
}

TEST_F(Pages, AreUsableByKeyboard) {
    constexpr int kTab = 9, kEnter = 13, kDown = 40;
    browser_->open(*folder_ / "cohort.html", 1280, 900);
    browser_->press("Tab", kTab);
    EXPECT_EQ(browser_->evaluate("document.activeElement.className"), "skip");
    bool chose = false, sorted = false, opened = false;
    for (int i = 0; i < 60 && !(chose && sorted && opened); ++i) {
        browser_->press("Tab", kTab);
        // The focused element has a visible outline.
        EXPECT_NE(browser_->evaluate("getComputedStyle(document.activeElement).outlineStyle"), "none");
        const std::string tag = browser_->evaluate("document.activeElement.tagName");
        if (tag == "SELECT" && !chose) {
            const auto before = browser_->evaluate("document.querySelector('canvas').toDataURL()");
            browser_->press("ArrowDown", kDown);
            EXPECT_EQ(browser_->evaluate("document.activeElement.selectedIndex"), 1);
            EXPECT_NE(browser_->evaluate("document.querySelector('canvas').toDataURL()"), before);
            chose = true;
        } else if (tag == "SUMMARY" && !opened) {
            browser_->press("Enter", kEnter);
            EXPECT_EQ(browser_->evaluate("document.activeElement.parentNode.open"), true);
            opened = true;
        } else if (tag == "BUTTON" && !sorted &&
                   browser_->evaluate("document.activeElement.textContent") == "Trainee") {
            const char* first =
                "document.activeElement.closest('table').tBodies[0].rows[0].cells[0].textContent";
            EXPECT_EQ(browser_->evaluate(first), "trainee-F");
            browser_->press("Enter", kEnter);
            EXPECT_EQ(browser_->evaluate(first), "trainee-A");
            EXPECT_EQ(browser_->evaluate("document.activeElement.parentNode.getAttribute('aria-sort')"),
                      "ascending");
            browser_->press("Enter", kEnter);
            EXPECT_EQ(browser_->evaluate(first), "trainee-F");
            sorted = true;
        }
    }
    EXPECT_TRUE(chose);
    EXPECT_TRUE(opened);
    EXPECT_TRUE(sorted);
}

TEST_F(Pages, SortInfinityAboveAllNumbers) {
    Page page("Sorted", "By its numbers.");
    page.table({"Values",
                {"Name", "Value"},
                {{"a", "2"}, {"b", "∞"}, {"c", "–"}, {"d", "10"}},
                {false, true},
                true});
    stylet::writeWholeFile(*folder_ / "sorted.html", page.html());
    browser_->open(*folder_ / "sorted.html", 1280, 900);
    const char* order =
        "document.querySelectorAll('th button')[1].click();Array.from(document.querySelectorAll('tbody "
        "th')).map(cell => cell.textContent).join('')";
    EXPECT_EQ(browser_->evaluate(order), "cadb");
    EXPECT_EQ(browser_->evaluate(order), "bdac");
}

TEST_F(Pages, TablesWorkWithoutScripts) {
    browser_->open(*folder_ / "attempt.html", 1280, 900, false);
    std::set<std::string> names;
    for (const Browser::Accessible& a : browser_->accessibles())
        names.insert(a.name);
    EXPECT_TRUE(names.contains("Metrics, their points and the cohort"));
    EXPECT_TRUE(names.contains("What happened, in order"));
}

}  // namespace
