// Checks the statements against IEEE 9274.1.1. xAPI 1.0.3 has the same rules for these properties.
#include "app/report/xapi.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "app/training/score.h"
#include "tests/app/report/attempts.h"
#include "tests/support/refused.h"

namespace {

using namespace stylet::report;
using nlohmann::json;
using stylet::test::makeTestAttempt;

bool isIri(const json& j) {
    static const std::regex iri("[a-z][a-z0-9+.-]*://[^\\s<>\"{}|\\\\^`]+");
    return j.is_string() && std::regex_match(j.get<std::string>(), iri);
}

bool isLanguageMap(const json& j) {
    if (!j.is_object() || j.empty()) return false;
    for (const auto& [tag, text] : j.items())
        if (!std::regex_match(tag, std::regex("[a-z]{2,3}(-[A-Za-z0-9]+)*")) || !text.is_string())
            return false;
    return true;
}

bool isUuid(const json& j) {
    static const std::regex uuid("[0-9a-f]{8}-[0-9a-f]{4}-[1-5][0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}");
    return j.is_string() && std::regex_match(j.get<std::string>(), uuid);
}

void expectOnly(const json& object, const std::set<std::string>& allowed, const std::string& where) {
    for (const auto& [name, value] : object.items()) {
        EXPECT_TRUE(allowed.contains(name)) << where << "." << name;
        EXPECT_FALSE(value.is_null()) << where << "." << name << ": null is for extensions only";
    }
}

void expectExtensions(const json& extensions) {
    for (const auto& [name, value] : extensions.items())
        EXPECT_TRUE(isIri(name)) << name;
}

void expectResult(const json& result) {
    static const std::regex duration("PT(\\d+H)?(\\d+M)?(\\d+(\\.\\d\\d)?S)?");
    expectOnly(result, {"score", "success", "completion", "response", "duration", "extensions"}, "result");
    if (result.contains("duration")) {
        EXPECT_TRUE(std::regex_match(result.at("duration").get<std::string>(), duration))
            << result.at("duration");
        EXPECT_NE(result.at("duration"), "PT");
    }
    EXPECT_TRUE(!result.contains("success") || result.at("success").is_boolean());
    EXPECT_TRUE(!result.contains("completion") || result.at("completion").is_boolean());
    if (result.contains("extensions")) expectExtensions(result.at("extensions"));
    if (!result.contains("score")) return;
    const json& score = result.at("score");
    expectOnly(score, {"scaled", "raw", "min", "max"}, "score");
    EXPECT_GE(score.at("scaled").get<double>(), -1.0);
    EXPECT_LE(score.at("scaled").get<double>(), 1.0);
    EXPECT_LT(score.at("min").get<double>(), score.at("max").get<double>());
    EXPECT_GE(score.at("raw").get<double>(), score.at("min").get<double>());
    EXPECT_LE(score.at("raw").get<double>(), score.at("max").get<double>());
}

// Section 4.2 of the standard, for the properties in use.
void expectStatement(const json& s) {
    static const std::regex time("\\d{4}-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\d(\\.\\d+)?Z");
    expectOnly(s,
               {"id", "actor", "verb", "object", "result", "context", "timestamp", "stored", "authority",
                "version", "attachments"},
               "statement");
    EXPECT_TRUE(isUuid(s.at("id"))) << s.at("id");
    const json& actor = s.at("actor");
    // `account` is the only inverse functional identifier.
    expectOnly(actor, {"objectType", "name", "account"}, "actor");
    EXPECT_EQ(actor.at("objectType"), "Agent");
    expectOnly(actor.at("account"), {"homePage", "name"}, "account");
    EXPECT_TRUE(isIri(actor.at("account").at("homePage")));
    EXPECT_FALSE(actor.at("account").at("name").get<std::string>().empty());
    expectOnly(s.at("verb"), {"id", "display"}, "verb");
    EXPECT_TRUE(isIri(s.at("verb").at("id")));
    EXPECT_TRUE(isLanguageMap(s.at("verb").at("display")));
    const json& object = s.at("object");
    expectOnly(object, {"objectType", "id", "definition"}, "object");
    EXPECT_EQ(object.at("objectType"), "Activity");
    EXPECT_TRUE(isIri(object.at("id"))) << object.at("id");
    expectOnly(object.at("definition"), {"name", "description", "type", "moreInfo", "extensions"},
               "definition");
    EXPECT_EQ(object.at("definition").at("type"), "http://adlnet.gov/expapi/activities/simulation");
    EXPECT_TRUE(isLanguageMap(object.at("definition").at("name")));
    EXPECT_TRUE(isLanguageMap(object.at("definition").at("description")));
    const json& context = s.at("context");
    expectOnly(context, {"registration", "platform", "language", "extensions"}, "context");
    EXPECT_TRUE(isUuid(context.at("registration")));
    expectExtensions(context.at("extensions"));
    if (s.contains("timestamp")) {
        EXPECT_TRUE(std::regex_match(s.at("timestamp").get<std::string>(), time)) << s.at("timestamp");
    }
    if (s.contains("result")) expectResult(s.at("result"));
}

std::vector<std::string> verbsOf(const json& statements) {
    std::vector<std::string> verbs;
    for (const json& s : statements) {
        const std::string id = s.at("verb").at("id");
        EXPECT_TRUE(id.starts_with("http://adlnet.gov/expapi/verbs/"));
        verbs.push_back(id.substr(id.rfind('/') + 1));
    }
    return verbs;
}

json exported(const std::vector<stylet::records::StoredAttempt>& attempts,
              const std::string& home = "https://lrs.example/stylet") {
    return json::parse(xapiStatements(attempts, {home}));
}

TEST(Xapi, EveryStatementConformsToXapi) {
    std::vector<stylet::records::StoredAttempt> attempts = stylet::test::makeTestCohort();
    auto hostile = makeTestAttempt(stylet::test::kHostile, stylet::test::kHostile, NAN, true);
    hostile.info.scenario = hostile.info.device = hostile.info.difficulty = hostile.info.program_version =
        stylet::test::kHostile;
    hostile.started_utc = "yesterday";
    hostile.result->metrics[0].value = INFINITY;
    hostile.result->metrics[0].id = stylet::test::kHostile;
    attempts.push_back(hostile);
    const json statements = exported(attempts);
    EXPECT_GT(statements.size(), 3 * attempts.size());
    std::set<std::string> ids;
    for (const json& s : statements) {
        expectStatement(s);
        ids.insert(s.at("id"));
    }
    EXPECT_EQ(ids.size(), statements.size());
}

TEST(Xapi, AttemptIsInitializedCompletedAndGraded) {
    const json passed = exported({makeTestAttempt("a", "t", 80.0, true)});
    EXPECT_EQ(verbsOf(passed),
              (std::vector<std::string>{"initialized", "completed", "passed", "terminated"}));
    EXPECT_EQ(passed[2].at("result").at("score").at("scaled"), 0.8);
    EXPECT_EQ(passed[2].at("result").at("success"), true);
    EXPECT_EQ(passed[3].at("result").at("duration"), "PT1M3.25S");
    EXPECT_EQ(passed[0].at("timestamp"), "2026-11-20T23:59:30.500Z");
    EXPECT_EQ(passed[3].at("timestamp"), "2026-11-21T00:00:33.750Z");
    EXPECT_EQ(verbsOf(exported({makeTestAttempt("a", "t", 80.0, false)}))[2], "failed");
    EXPECT_EQ(verbsOf(exported({makeTestAttempt("a", "t", stylet::training::kPassMark - 0.1, true)}))[2],
              "failed");
    EXPECT_EQ(verbsOf(exported({makeTestAttempt("a", "t", stylet::training::kPassMark, true)}))[2], "passed");
}

TEST(Xapi, UnfinishedAttemptIsTerminatedNotCompleted) {
    auto attempt = makeTestAttempt("a", "t", 80.0, true);
    attempt.result.reset();
    attempt.state = stylet::records::AttemptState::cut_short;
    const json cut = exported({attempt});
    EXPECT_EQ(verbsOf(cut), (std::vector<std::string>{"initialized", "terminated"}));
    EXPECT_EQ(cut[1].at("result").at("completion"), false);
    EXPECT_EQ(cut[1].at("result").at("duration"), "PT50S");
    attempt.state = stylet::records::AttemptState::running;
    EXPECT_EQ(verbsOf(exported({attempt})), std::vector<std::string>{"initialized"});
    attempt.info.trainee.clear();
    EXPECT_EQ(exported({attempt}), json::array());
}

// Neither passed nor failed: an aborted attempt enters no statistics.
TEST(Xapi, AbortedAttemptIsTerminatedNotGraded) {
    auto attempt = makeTestAttempt("a", "t", 0.0, false);
    attempt.result->aborted = true;
    EXPECT_EQ(verbsOf(exported({attempt})), (std::vector<std::string>{"initialized", "terminated"}));
}

TEST(Xapi, AnExamThatWasCutShortIsFailed) {
    auto attempt = makeTestAttempt("a", "t", 0.0, false);
    attempt.info.difficulty = "exam";
    attempt.state = stylet::records::AttemptState::cut_short;
    attempt.result.reset();
    attempt.events.push_back({51000, "critical", "the lung was punctured"});
    const json cut = exported({attempt});
    EXPECT_EQ(verbsOf(cut), (std::vector<std::string>{"initialized", "failed", "terminated"}));
    EXPECT_EQ(cut[1].at("result").at("success"), false);
}

TEST(Xapi, StatementsAreReproducible) {
    const auto a = makeTestAttempt("a", "t", 80.0, true), b = makeTestAttempt("b", "t", 80.0, true);
    EXPECT_EQ(exported({a}), exported({a}));
    EXPECT_NE(exported({a})[0].at("id"), exported({b})[0].at("id"));
    EXPECT_NE(exported({a})[0].at("context").at("registration"),
              exported({b})[0].at("context").at("registration"));
    EXPECT_NE(exported({a})[0].at("id"), exported({a}, "https://other.example")[0].at("id"));
}

// Most readers of JSON keep numbers with 53 bits.
TEST(Xapi, SeedIsExact) {
    auto attempt = makeTestAttempt("a", "t", 80.0, true);
    attempt.info.seed = std::numeric_limits<std::uint64_t>::max();
    EXPECT_EQ(
        exported({attempt})[0].at("context").at("extensions").at("https://lrs.example/stylet/xapi/seed"),
        "18446744073709551615");
}

// HZ-RECORD-10
TEST(Xapi, PatientIsNotNamed) {
    const std::string text = xapiStatements({makeTestAttempt("a", "t", 80.0, true)}, {});
    EXPECT_EQ(text.find("reference patient"), std::string::npos);
}

TEST(Xapi, DurationsAreIso8601) {
    EXPECT_EQ(isoDuration(0.0), "PT0S");
    EXPECT_EQ(isoDuration(0.006), "PT0.01S");
    EXPECT_EQ(isoDuration(59.999), "PT1M");
    EXPECT_EQ(isoDuration(3600.0), "PT1H");
    EXPECT_EQ(isoDuration(3725.5), "PT1H2M5.50S");
    EXPECT_EQ(isoDuration(NAN), "PT0S");
    EXPECT_EQ(isoDuration(-1.0), "PT0S");
}

TEST(Xapi, RefusesInvalidHomeAddress) {
    for (const char* home :
         {"", "stylet", "ftp://a", "https://", "https:///x", "https://a b", "https://a/", "https://a\"b"})
        stylet::test::expectRefused([&] { xapiStatements({}, {home}); }, "xAPI", "home");
}

}  // namespace
