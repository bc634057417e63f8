// Fields are read from TOML and JSON in the same way. Every error names file, field and reason.
#include "base/fields.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/refused.h"

namespace stylet {
namespace {

using test::errorText;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const std::string kToml = R"(
number = 2.5
whole = -3
digits = "00f1e2d3c4b5a697"
yes = true
text = "caf\u00e9"
empty = ""
point = [1, 2.5, -3.0]
bins = [4, 0, 7]
words = ["a", "b"]
date = 2026-01-02
[part]
length_m = 0.25
[part.inner]
size = 1
[[row]]
id = 1
[[row]]
id = 2
name = "second"
)";

const std::string kJson = R"({"number": 2.5, "whole": -3, "digits": "00f1e2d3c4b5a697", "yes": true,
    "text": "caf\u00e9", "empty": "", "point": [1, 2.5, -3.0], "bins": [4, 0, 7], "words": ["a", "b"],
    "date": null, "part": {"length_m": 0.25, "inner": {"size": 1}},
    "row": [{"id": 1}, {"id": 2, "name": "second"}]})";

struct FieldsInBothFormats : testing::TestWithParam<bool> {
    Fields parsed() const { return GetParam() ? parseJson("f", kJson) : parseToml("f", kToml); }
    // Expects that `read` throws on the valid file, with a text that begins with "f: " and `message`.
    template <typename Read>
    void expectRefused(const Read& read, const std::string& message) const {
        Fields in = parsed();
        EXPECT_EQ(errorText([&] { read(in); }), "f: " + message);
    }
    std::string table() const { return GetParam() ? "not an object" : "not a table"; }
};
INSTANTIATE_TEST_SUITE_P(TomlAndJson, FieldsInBothFormats, testing::Bool(),
                         [](const auto& format) { return format.param ? "Json" : "Toml"; });

TEST_P(FieldsInBothFormats, AreReadEqually) {
    Fields in = parsed();
    EXPECT_EQ(in.file(), "f");
    EXPECT_EQ(in.number("number", 2.5, 2.5), 2.5);
    EXPECT_EQ(in.number("whole", -3.0, 0.0), -3.0);
    EXPECT_EQ(in.integer("whole", -3, -3), -3);
    EXPECT_EQ(in.hex("digits"), 0x00f1e2d3c4b5a697u);
    EXPECT_TRUE(in.flag("yes"));
    EXPECT_EQ(in.text("text", 5), "caf\xc3\xa9");
    EXPECT_EQ(in.nonEmptyText("text"), "caf\xc3\xa9");
    EXPECT_EQ(in.text("empty", 0), "");
    EXPECT_EQ(in.vector("point", -3.0, 2.5), Vec3(1.0, 2.5, -3.0));
    EXPECT_EQ(in.numbers<3>("point", -3.0, 2.5)[1], 2.5);
    EXPECT_EQ(in.integers("bins", 0, 7, 3), (std::vector<std::int64_t>{4, 0, 7}));
    EXPECT_EQ(in.texts("words", 2, 1), (std::vector<std::string>{"a", "b"}));
}

TEST_P(FieldsInBothFormats, FinishRejectsUnreadKeys) {
    Fields in = parsed();
    for (const char* key : {"bins", "date", "digits", "empty", "number", "point", "text", "whole", "words"})
        in.ignore(key);
    in.ignore("no such key");
    EXPECT_EQ(errorText([&] { in.finish(); }), "f: part: unknown key");
    Fields part = in.child("part");
    EXPECT_EQ(part.number("length_m", 0.0, 1.0), 0.25);
    EXPECT_EQ(errorText([&] { part.finish(); }), "f: part.inner: unknown key");
    EXPECT_EQ(part.child("inner").count("size"), 1u);
    part.finish();
    EXPECT_EQ(errorText([&] { in.finish(); }), "f: row: unknown key");
    std::vector<Fields> rows = in.children("row", 2);
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[1].integer("id", 0, 9), 2);
    EXPECT_EQ(errorText([&] { rows[1].finish(); }), "f: row[1].name: unknown key");
    EXPECT_EQ(errorText([&] { in.finish(); }), "f: yes: unknown key");
    in.flag("yes");
    in.finish();
}

TEST_P(FieldsInBothFormats, MayBeAbsent) {
    Fields in = parsed();
    EXPECT_FALSE(in.has("none"));
    EXPECT_EQ(in.numberOr("none", 0.0, 1.0, 7.0), 7.0);
    EXPECT_EQ(in.numberOr("number", 0.0, 3.0, 7.0), 2.5);
    EXPECT_EQ(in.textOr("none", "other"), "other");
    EXPECT_EQ(in.textOr("text", "other"), "caf\xc3\xa9");
    EXPECT_TRUE(in.childrenOrNone("none", 1).empty());
    EXPECT_THROW(in.children("none", 1), DataError);
    EXPECT_FALSE(in.childOrEmpty("none").has("length_m"));
    EXPECT_TRUE(in.childOrEmpty("part").has("length_m"));
    EXPECT_EQ(errorText([&] { in.childOrEmpty("none").flag("yes"); }), "f: none.yes: missing");
}

TEST_P(FieldsInBothFormats, HaveAKind) {
    const Fields in = parsed();
    EXPECT_EQ(in.kind("none"), FieldKind::absent);
    EXPECT_EQ(in.kind("date"), FieldKind::null);
    EXPECT_EQ(in.kind("yes"), FieldKind::flag);
    EXPECT_EQ(in.kind("number"), FieldKind::number);
    EXPECT_EQ(in.kind("whole"), FieldKind::number);
    EXPECT_EQ(in.kind("text"), FieldKind::text);
    EXPECT_EQ(in.kind("point"), FieldKind::list);
    EXPECT_EQ(in.kind("part"), FieldKind::table);
}

TEST_P(FieldsInBothFormats, AreRejectedWithNameAndReason) {
    expectRefused([](Fields& in) { in.refuse("a", "wrong"); }, "a: wrong");
    expectRefused([](Fields& in) { in.child("part").child("inner").refuse("a", "wrong"); },
                  "part.inner.a: wrong");
    for (const char* key : {"none", "part.length_m"}) {
        const std::string missing = std::string(key) + ": missing";
        expectRefused([&](Fields& in) { in.number(key, 0, 1); }, missing);
        expectRefused([&](Fields& in) { in.integer(key, 0, 1); }, missing);
        expectRefused([&](Fields& in) { in.count(key); }, missing);
        expectRefused([&](Fields& in) { in.hex(key); }, missing);
        expectRefused([&](Fields& in) { in.flag(key); }, missing);
        expectRefused([&](Fields& in) { in.text(key); }, missing);
        expectRefused([&](Fields& in) { in.numbers<3>(key, 0, 1); }, missing);
        expectRefused([&](Fields& in) { in.integers(key, 0, 1, 1); }, missing);
        expectRefused([&](Fields& in) { in.texts(key, 1); }, missing);
        expectRefused([&](Fields& in) { in.child(key); }, missing);
    }
}

TEST_P(FieldsInBothFormats, MustHaveTheirType) {
    expectRefused([](Fields& in) { in.number("text", 0, 1); }, "text: not a number");
    expectRefused([](Fields& in) { in.number("date", 0, 1); }, "date: not a number");
    expectRefused([](Fields& in) { in.integer("number", 0, 9); }, "number: not an integer");
    expectRefused([](Fields& in) { in.count("number"); }, "number: not an integer");
    expectRefused([](Fields& in) { in.hex("text"); }, "text: not 16 hexadecimal digits");
    expectRefused([](Fields& in) { in.flag("whole"); }, "whole: not true or false");
    expectRefused([](Fields& in) { in.text("number"); }, "number: not a string");
    expectRefused([](Fields& in) { in.vector("number", 0, 1); }, "number: not 3 numbers");
    expectRefused([](Fields& in) { in.numbers<2>("words", 0, 1); }, "words: not a number");
    expectRefused([](Fields& in) { in.integers("point", -9, 9, 3); }, "point: not an integer");
    expectRefused([](Fields& in) { in.integers("part", -9, 9, 3); }, "part: not an array");
    expectRefused([](Fields& in) { in.texts("bins", 3); }, "bins: not a string");
    expectRefused([&](Fields& in) { in.child("row"); }, "row: " + table());
    expectRefused([&](Fields& in) { in.childOrEmpty("text"); }, "text: " + table());
    expectRefused([](Fields& in) { in.children("part", 1); }, "part: not an array");
    expectRefused([&](Fields& in) { in.children("bins", 3); }, "bins[0]: " + table());
}

TEST_P(FieldsInBothFormats, MustBeWithinLimits) {
    expectRefused([](Fields& in) { in.number("number", 3, 4); }, "number: 2.5 is not in [3, 4]");
    expectRefused([](Fields& in) { in.numberOr("number", 0, 1, 0); }, "number: 2.5 is not in [0, 1]");
    expectRefused([](Fields& in) { in.integer("whole", -2, 4); }, "whole: -3 is not in [-2, 4]");
    expectRefused([](Fields& in) { in.integer("whole", -9, -4); }, "whole: -3 is not in [-9, -4]");
    expectRefused([](Fields& in) { in.count("whole"); }, "whole: -3 is not in [0, 9223372036854775807]");
    expectRefused([](Fields& in) { in.text("text", 4); }, "text: longer than 4 bytes");
    expectRefused([](Fields& in) { in.nonEmptyText("empty"); }, "empty: empty");
    expectRefused([](Fields& in) { in.numbers<2>("point", -9, 9); }, "point: not 2 numbers");
    expectRefused([](Fields& in) { in.vector("point", -2, 9); }, "point: -3 is not in [-2, 9]");
    expectRefused([](Fields& in) { in.integers("bins", 0, 6, 3); }, "bins: 7 is not in [0, 6]");
    expectRefused([](Fields& in) { in.integers("bins", 0, 7, 2); }, "bins: more than 2 entries");
    expectRefused([](Fields& in) { in.texts("words", 1); }, "words: more than 1 entries");
    expectRefused([](Fields& in) { in.texts("words", 2, 0); }, "words: longer than 0 bytes");
    expectRefused([](Fields& in) { in.children("row", 1); }, "row: more than 1 entries");
}

TEST(FieldsInToml, MayBeInfiniteButNeverNan) {
    Fields in = parseToml("f", "most = inf\nnone = nan");
    EXPECT_EQ(in.number("most", 0.0, kInfinity), kInfinity);
    EXPECT_EQ(in.number("most"), kInfinity);
    EXPECT_EQ(errorText([&] { in.number("none", -kInfinity, kInfinity); }),
              "f: none: nan is not in [-inf, inf]");
}

TEST(FieldsInJson, HaveUnsignedIntegersOf64Bits) {
    Fields in = parseJson("f", R"({"seed": 18446744073709551615, "large": 18446744073709551616})");
    EXPECT_EQ(in.count("seed"), UINT64_MAX);
    EXPECT_EQ(in.number("seed", 0.0, 2e19), 18446744073709551616.0);
    EXPECT_EQ(errorText([&] { in.integer("seed", 0, INT64_MAX); }), "f: seed: not an integer");
    EXPECT_EQ(errorText([&] { in.count("large"); }), "f: large: not an integer");
}

TEST(FieldsInJson, ReportDuplicateKeys) {
    Fields in = parseJson("f", R"({"a": 1, "b": {"c": 1, "a": 3, "c": 2}, "a": 2})");
    EXPECT_EQ(in.duplicateKeys(), (std::vector<std::string>{"c", "a"}));
    EXPECT_EQ(in.integer("a", 0, 9), 2);
    EXPECT_TRUE(parseJson("f", "{}").duplicateKeys().empty());
}

TEST(FieldsInJson, MustBeJson) {
    for (const std::string& text : {std::string(), std::string("{"), std::string("{} {}"), std::string("[]"),
                                    std::string("{\"a\": 1e999}"), std::string("{\"a\": \"\xff\"}"),
                                    std::string(100'000, '['), std::string("1")})
        EXPECT_EQ(errorText([&] { parseJson("f", text); }).rfind("f: json: ", 0), 0u) << text.substr(0, 20);
    EXPECT_EQ(
        errorText([] { parseJson("f", "x,y\n"); }).rfind("f: json: parse error at line 1, column 1: ", 0), 0u)
        << "without the library's own prefix";
}

TEST(FieldsInToml, MustBeToml) {
    EXPECT_EQ(errorText([] { parseToml("f", "a = 1\nb = = 2"); }).rfind("f: line 2: ", 0), 0u);
    EXPECT_NE(errorText([] { parseToml("f", "a = 1\na = 2"); }), "");
    EXPECT_NE(errorText([] { parseToml("f", "a = \"\xff\""); }), "");
    std::string deep = "a = 1";
    for (int i = 0; i < 70; ++i)
        deep.insert(0, "a.");
    EXPECT_EQ(errorText([&] { parseToml("f", deep); }), "f: toml: nested too deeply");
}

// A Fields that owns its file can be moved. Its children stay valid.
TEST(Fields, MoveWithTheirFile) {
    Fields first = parseToml("f", "[part]\nsize = 3");
    Fields part = first.child("part");
    const Fields second = std::move(first);
    EXPECT_EQ(part.integer("size", 0, 9), 3);
    EXPECT_TRUE(second.has("part"));
}

}  // namespace
}  // namespace stylet
