#include "base/csv.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/refused.h"

namespace stylet {
namespace {

constexpr std::string_view kColumns = "name,count,share";

// Reads a table of kColumns and returns the error, or an empty text.
std::string refusal(const std::string& text) {
    const std::filesystem::path file = "t.csv";
    return test::errorText([&] {
        CsvReader rows(file, text, kColumns);
        while (rows.next()) {
            rows.text();
            rows.number(0, 9);
            rows.number<double>();
        }
    });
}

TEST(CsvReader, ReadsEveryRowAndField) {
    const std::filesystem::path file = "t.csv";
    const std::string text = "name;count;share\r\nliver;3;0.5\r\n;-4;1e-3";
    CsvReader rows(file, text, "name;count;share", ';');
    ASSERT_TRUE(rows.next());
    EXPECT_EQ(rows.text(), "liver");
    EXPECT_EQ(rows.number<int>(), 3);
    EXPECT_EQ(rows.number<double>(), 0.5);
    ASSERT_TRUE(rows.next());
    EXPECT_EQ(rows.text(), "");
    EXPECT_EQ(rows.number<int>(), -4);
    EXPECT_EQ(rows.number<double>(), 1e-3);
    EXPECT_FALSE(rows.next());
}

// Spreadsheets write a byte order mark, and some end lines with CR alone.
TEST(CsvReader, AcceptsFilesOfSpreadsheets) {
    EXPECT_EQ(refusal("\xEF\xBB\xBFname,count,share\r\na,1,0.5\r\n"), "");
    EXPECT_EQ(refusal("name,count,share\ra,1,0.5\rb,2,0.5"), "");
    EXPECT_EQ(refusal("name,count,share\ra,1,0.5\rb,x,0.5\r"), "t.csv: line 3: count: \"x\" is not a number");
}

TEST(CsvReader, RefusalsNameLineAndColumn) {
    EXPECT_EQ(refusal("name,count,share\na,1,0.5\n"), "");
    EXPECT_EQ(refusal(""), "t.csv: line 1: the columns are not name,count,share");
    EXPECT_EQ(refusal("name,count\n"), "t.csv: line 1: the columns are not name,count,share");
    EXPECT_EQ(refusal("name,count,share\na,1\n"), "t.csv: line 2: 2 fields, not 3");
    EXPECT_EQ(refusal("name,count,share\na,1,2,3\n"), "t.csv: line 2: 4 fields, not 3");
    EXPECT_EQ(refusal("name,count,share\n\n"), "t.csv: line 2: 1 fields, not 3");
    EXPECT_EQ(refusal("name,count,share\na,1,1\nb,x,1\n"), "t.csv: line 3: count: \"x\" is not a number");
    EXPECT_EQ(refusal("name,count,share\na,10,1\n"), "t.csv: line 2: count: 10 is not from 0 to 9");
    for (const char* bad : {"nan", "inf", "-inf", "1e999", "", " 1", "0x1"})
        EXPECT_NE(refusal(std::string("name,count,share\na,1,") + bad).find("line 2: share: "),
                  std::string::npos)
            << bad;
}

TEST(CsvReader, LongFieldsAreShortenedInMessages) {
    EXPECT_LT(refusal("name,count,share\na," + std::string(100'000, '9') + ",1\n").size(), 100u);
}

TEST(CsvRow, QuotesCellsThatNeedIt) {
    const std::vector<std::string> cells{"a", "b,c", "say \"x\"", "two\nlines", ""};
    EXPECT_EQ(csvRow(cells), "a,\"b,c\",\"say \"\"x\"\"\",\"two\nlines\",");
}

TEST(CsvRow, SpreadsheetsDoNotEvaluateTexts) {
    const std::vector<std::string> cells{"=1+1", "-2.5", "-x", "@a", "+1"};
    EXPECT_EQ(csvRow(cells), "'=1+1,-2.5,'-x,'@a,'+1");
}

}  // namespace
}  // namespace stylet
