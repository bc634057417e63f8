#include "app/records/result.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/fields.h"
#include "tests/app/records/some_result.h"
#include "tests/support/refused.h"

namespace stylet::records {
namespace {

using nlohmann::json;

AttemptResult parsed(const json& document) {
    return parseResult(parseJson("record.json", document.dump()));
}

// The written object is a list of every number, so equal objects mean equal results.
TEST(Result, RestoresEveryField) {
    const json written = resultJson(test::someResult());
    EXPECT_EQ(json(resultJson(parsed(written))), written);
    const AttemptResult result = parsed(written);
    EXPECT_TRUE(std::isinf(result.metrics.at(0).value));
    EXPECT_TRUE(std::isnan(result.metrics.at(1).value));
    EXPECT_EQ(result.contrast.front_m, -INFINITY);
    EXPECT_EQ(result.punctures.at(0).tenting_m, 1.0 / 3.0);
    AttemptResult none = test::someResult();
    none.force_truth.reset();
    EXPECT_FALSE(parsed(resultJson(none)).force_truth);
}

// Removes, replaces and adds each field in turn, at every depth.
TEST(Result, EachFieldIsNeededAndChecked) {
    const json written = resultJson(test::someResult());
    const json flat = written.flatten();
    EXPECT_GT(flat.size(), 60u);
    for (const auto& [pointer, value] : flat.items()) {
        const json::json_pointer at(pointer);
        const std::string key = at.back();
        json changed = written;
        changed.at(at) = json::object({{"odd", 1}});
        EXPECT_NE(test::errorText([&] { parsed(changed); }).find("record.json: "), std::string::npos)
            << pointer;
        const bool element = std::isdigit(static_cast<unsigned char>(key.front())) != 0;
        if (element) continue;
        EXPECT_NE(test::errorText([&] { parsed(changed); }).find(key), std::string::npos) << pointer;
        if (key == "aborted" || key == "version" || key == "anaesthetic_ml")
            continue;  // older records lack them
        changed = written;
        changed.at(at.parent_pointer()).erase(key);
        EXPECT_NE(test::errorText([&] { parsed(changed); }).find(key), std::string::npos) << pointer;
        changed = written;
        changed.at(at.parent_pointer())["unheard_of"] = value;
        EXPECT_NE(test::errorText([&] { parsed(changed); }).find("unheard_of"), std::string::npos) << pointer;
    }
}

TEST(Result, OlderRecordsAreOfScoreVersion1AndNotAborted) {
    AttemptResult result = test::someResult();
    result.aborted = true, result.score_version = 7;
    json written = resultJson(result);
    EXPECT_TRUE(parsed(written).aborted);
    EXPECT_EQ(parsed(written).score_version, 7u);
    written.erase("aborted");
    written.at("score").erase("version");
    EXPECT_FALSE(parsed(written).aborted);
    EXPECT_EQ(parsed(written).score_version, 1u);
}

TEST(Result, NumbersThatAreNoneAreRefused) {
    for (const char* text : {"NaN", "nan", "Infinity", "1e3", ""}) {
        json changed = resultJson(test::someResult());
        changed["peak_force_n"] = text;
        test::expectRefused([&] { parsed(changed); }, "record.json", "peak_force_n");
    }
    for (const json& count : {json(-1), json(1.5), json("1"), json(true), json(nullptr)}) {
        json changed = resultJson(test::someResult());
        changed["ticks"] = count;
        test::expectRefused([&] { parsed(changed); }, "record.json", "ticks");
    }
}

}  // namespace
}  // namespace stylet::records
