#include "app/report/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/report/attempts.h"
#include "tests/app/trainer/command.h"
#include "tests/support/refused.h"

namespace {

using namespace stylet::report;
using stylet::test::kHostile;

std::string base64Of(const std::string& text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::size_t occurrences(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

TEST(Page, Base64AsInRfc4648) {
    EXPECT_EQ(base64Of(""), "");
    EXPECT_EQ(base64Of("f"), "Zg==");
    EXPECT_EQ(base64Of("fo"), "Zm8=");
    EXPECT_EQ(base64Of("foo"), "Zm9v");
    EXPECT_EQ(base64Of("foob"), "Zm9vYg==");
    EXPECT_EQ(base64Of("fooba"), "Zm9vYmE=");
    EXPECT_EQ(base64Of("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64Of("\xFB\xFF"), "+/8=");
}

TEST(Page, AnyBytesBecomeText) {
    const std::string bad = "\xEF\xBF\xBD";
    EXPECT_EQ(plainText("Gallenwege – ∞ 😀\n\t"), "Gallenwege – ∞ 😀\n\t");
    EXPECT_EQ(plainText("a\x01"
                        "b\x7F"),
              "a" + bad + "b" + bad);
    EXPECT_EQ(plainText(std::string_view("\0x", 2)), bad + "x");
    EXPECT_EQ(plainText("\xC0\xAF"), bad + bad);            // overlong
    EXPECT_EQ(plainText("\xED\xA0\x80"), bad + bad + bad);  // a surrogate
    EXPECT_EQ(plainText("\xF5\x80\x80\x80"), bad + bad + bad + bad);
    EXPECT_EQ(plainText("\xE2\x82"), bad + bad);                                               // cut off
    EXPECT_EQ(plainText("a\u202Eb\u2067c\u200Dשלום"), "a" + bad + "b" + bad + "c\u200Dשלום");  // direction
    EXPECT_EQ(escaped("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
}

TEST(Page, NumbersAreFormatted) {
    EXPECT_EQ(fixed(1.005, 1), "1.0");
    EXPECT_EQ(fixed(-0.001, 2), "0.00");
    EXPECT_EQ(fixed(-0.5, 1), "-0.5");
    EXPECT_EQ(fixed(NAN, 2), "–");
    EXPECT_EQ(fixed(INFINITY, 2), "∞");
    EXPECT_GT(fixed(1e300, 0).size(), 300u);
    EXPECT_EQ(clockText(0.0), "0:00.0");
    EXPECT_EQ(clockText(59.96), "1:00.0");
    EXPECT_EQ(clockText(605.25), "10:05.3");
    EXPECT_EQ(clockText(NAN), "–");
}

// HZ-RECORD-11
TEST(Page, TextNeverBecomesMarkup) {
    Page page(kHostile, kHostile, kHostile);
    page.headlines({{kHostile, kHostile}});
    page.section(kHostile);
    page.paragraph(kHostile);
    page.facts({{kHostile, kHostile}});
    const Table table{kHostile, {kHostile, kHostile}, {{kHostile, kHostile}}, {false, true}, true};
    page.table(table);
    Figure figure;
    figure.x = {kHostile}, figure.y = {kHostile};
    figure.x.names = {kHostile};
    figure.series = {{kHostile, kBlue, {{0.0, 1.0, kHostile}}}};
    figure.bands = {{0.0, 1.0, kHostile, kBlue}};
    figure.spans = {{0, 0.0, 1.0, kHostile, kBlue}};
    figure.lines = {{0.5, kHostile}};
    figure.marks = {{0.5, 0.5, kHostile}};
    figure.choices = {{kHostile, {kHostile}, figure.series}};
    page.figure({figure, kHostile, kHostile, table});
    page.picture({{1, 2, 3}, "image/png", 1, 1, kHostile, kHostile});
    page.stills({{{1, 2, 3}, "image/png", 1, 1, kHostile, kHostile}});
    const std::string html = page.html();
    EXPECT_EQ(html.find("<script>alert"), std::string::npos);
    EXPECT_EQ(html.find("<img src=x"), std::string::npos);
    EXPECT_EQ(html.find('\x01'), std::string::npos);
    EXPECT_EQ(html.find('\xFF'), std::string::npos);
    // Three script elements: the figure's numbers, chart.js and page.js.
    EXPECT_EQ(occurrences(html, "<script"), 3u);
    EXPECT_EQ(occurrences(html, "</script>"), 3u);
    EXPECT_EQ(occurrences(html, "<img "), 2u);
}

TEST(Page, FigureJsonContainsNumbersAndTexts) {
    Figure figure;
    figure.x = {"depth [mm]", 0.0};
    figure.series = {{kHostile, kBlue, {{1.0, 2.5}, {1.23456789, kGap}, {3e-7, INFINITY}}}};
    const auto j = nlohmann::json::parse(figureJson(figure));
    EXPECT_EQ(j.at("series").at(0).at("name"), plainText(kHostile));
    EXPECT_EQ(j.at("series").at(0).at("colour"), "#0072b2");
    EXPECT_EQ(j.at("series").at(0).at("points").dump(), "[[1,2.5],[1.2346,null],[3e-07,null]]");
    EXPECT_EQ(j.at("x").at("min"), 0.0);
    figure.boxes = {{1.0, 0.1, 0.2, 0.3, 0.4, INFINITY, kGreen}};
    EXPECT_EQ(nlohmann::json::parse(figureJson(figure)).at("boxes").dump(),
              R"([{"colour":"#007a5a","high":null,"low":0.1,"lower":0.2,"median":0.3,"upper":0.4,"x":1}])");
}

TEST(Page, SecurityPolicyListsScriptHashes) {
    Page page("t", "l");
    page.figure({{}, "d", "c", {}});
    const std::string html = page.html();
    EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
    EXPECT_EQ(html.find("unsafe"), std::string::npos);
    EXPECT_EQ(occurrences(html, "'sha256-"), 3u);
    EXPECT_NE(html.find("Chart.js v3"), std::string::npos);  // including its licence line
    EXPECT_NE(html.find("MIT License"), std::string::npos);
    // The only addresses are those in comments and names of chart.js: the page loads nothing.
    EXPECT_EQ(html.find("src=\"http"), std::string::npos);
    EXPECT_EQ(html.find("url("), std::string::npos);
    EXPECT_EQ(html.find("@import"), std::string::npos);
}

TEST(Page, DownsampledCurvePreservesPeaksAndGaps) {
    std::vector<FigurePoint> points;
    for (int i = 0; i < 100000; ++i)
        points.push_back({double(i), std::sin(i * 1e-3)});
    points[31415].y = 99.0;
    points[27182].y = -99.0;
    points[50000].y = kGap;
    const std::vector<FigurePoint> kept = downsample(points, 500);
    EXPECT_LE(kept.size(), 2501u);
    bool peak = false, dip = false, gap = false;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_TRUE(i == 0 || kept[i].x > kept[i - 1].x);
        peak |= kept[i].y == 99.0, dip |= kept[i].y == -99.0, gap |= std::isnan(kept[i].y);
    }
    EXPECT_TRUE(peak && dip && gap);
    EXPECT_EQ(kept.front().x, 0.0);
    EXPECT_EQ(kept.back().x, 99999.0);
    EXPECT_EQ(downsample({points.begin(), points.begin() + 10}, 500).size(), 10u);
    EXPECT_TRUE(downsample({}, 5).empty());
}

TEST(Page, CsvTablesAreSafeForSpreadsheets) {
    const stylet::test::TempFolder folder;
    const Table table{
        "", {"name", "value [mm]"}, {{"=1+2", "-1.5"}, {"a,\"b\"", "2"}, {"@x", "3"}}, {false, true}};
    writeCsv(table, folder / "t.csv");
    EXPECT_EQ(stylet::test::readText(folder / "t.csv"),
              "name,value [mm]\n'=1+2,-1.5\n\"a,\"\"b\"\"\",2\n'@x,3\n");
    stylet::test::expectRefused([&] { writeCsv(table, folder / "no" / "t.csv"); }, "t.csv", "file");
}

}  // namespace
