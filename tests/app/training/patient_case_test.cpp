#include "app/training/patient_case.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/app/trainer/assets.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"

namespace stylet::training {
namespace {

const std::filesystem::path kCases = test::assets() / "cases";

PatientCase shipped(const std::string& name) {
    return loadCase(kCases / (name + ".toml"));
}

// "ynn...": the right answers in the order of the questions.
std::string answersOf(const PatientCase& c) {
    std::string answers;
    for (int i = 0; i < kQuestionCount; ++i)
        answers += rightAnswer(c, Question(i)) ? 'y' : 'n';
    return answers;
}

// Of clotting, thinner, ascites, contrast, consent, antibiotic, begin.
TEST(PatientCase, ShippedCasesHaveTheAnswersOfTheStandards) {
    const std::map<std::string, std::string> expected{
        {"clean", "nnnnnyy"},         {"raised-inr", "ynnnnyn"},        {"low-platelets", "ynnnnyn"},
        {"liver-disease", "nnnnnyy"}, {"contrast-reaction", "nnnynyn"}, {"missing-consent", "nnnnyyn"},
        {"apixaban", "nynynnn"},      {"stopped-aspirin", "nnnnnny"},   {"ascites", "nnynnyn"},
        {"septic-shock", "ynnnnny"}};
    std::size_t found = 0;
    for (const auto& entry : std::filesystem::directory_iterator(kCases)) {
        if (entry.path().extension() != ".toml") continue;
        ++found;
        const std::string name = entry.path().stem();
        ASSERT_TRUE(expected.contains(name)) << name;
        EXPECT_EQ(answersOf(loadCase(entry.path())), expected.at(name)) << name;
    }
    EXPECT_EQ(found, expected.size());
}

TEST(PatientCase, LimitsAreThoseOfTheConsensus) {
    PatientCase c = shipped("clean");
    const auto needsClotting = [&](double inr, double platelets, bool liver) {
        c.inr = inr, c.platelets_e9_per_l = platelets, c.liver_disease = liver;
        return rightAnswer(c, Question::clotting);
    };
    EXPECT_FALSE(needsClotting(1.8, 50.0, false));
    EXPECT_TRUE(needsClotting(1.81, 50.0, false));
    EXPECT_TRUE(needsClotting(1.8, 49.0, false));
    EXPECT_FALSE(needsClotting(2.5, 30.0, true));
    EXPECT_TRUE(needsClotting(2.51, 30.0, true));
    EXPECT_TRUE(needsClotting(2.5, 29.0, true));
    EXPECT_FALSE(rightAnswer(c, Question::begin)) << "what is to be corrected is waited for";

    c = shipped("clean");
    const auto waits = [&](Thinner thinner, double hours, double egfr) {
        c.thinner = thinner, c.last_dose_h = hours, c.egfr_ml_per_min = egfr;
        return rightAnswer(c, Question::thinner);
    };
    EXPECT_TRUE(waits(Thinner::aspirin, 71.0, 80.0));
    EXPECT_FALSE(waits(Thinner::aspirin, 72.0, 80.0));
    EXPECT_TRUE(waits(Thinner::clopidogrel, 119.0, 80.0));
    EXPECT_FALSE(waits(Thinner::clopidogrel, 120.0, 80.0));
    EXPECT_TRUE(waits(Thinner::enoxaparin, 23.0, 80.0));
    EXPECT_FALSE(waits(Thinner::enoxaparin, 24.0, 80.0));
    EXPECT_FALSE(waits(Thinner::apixaban, 48.0, 50.0));
    EXPECT_TRUE(waits(Thinner::apixaban, 48.0, 49.0));
    EXPECT_FALSE(waits(Thinner::apixaban, 72.0, 49.0));
    EXPECT_FALSE(waits(Thinner::dabigatran, 48.0, 50.0));
    EXPECT_TRUE(waits(Thinner::dabigatran, 95.0, 49.0));
    EXPECT_FALSE(waits(Thinner::warfarin, 1.0, 80.0)) << "the INR shows that it does not act";
    c.inr = 1.9;
    EXPECT_TRUE(waits(Thinner::warfarin, 200.0, 80.0));

    c = shipped("clean");
    for (const auto& [minutes, needed] : {std::pair(60.0, false), std::pair(61.0, true)}) {
        c.antibiotic_min = minutes;
        EXPECT_EQ(rightAnswer(c, Question::antibiotic), needed) << minutes;
    }
    EXPECT_TRUE(rightAnswer(c, Question::begin)) << "an antibiotic takes no time";
}

TEST(PatientCase, WhatIsLeftOutIsUnsafeAndANeedlessCorrectionIsNot) {
    const PatientCase bleeds = shipped("raised-inr"), well = shipped("clean"),
                      shock = shipped("septic-shock");
    EXPECT_TRUE(isUnsafe(bleeds, Question::clotting, false));
    EXPECT_TRUE(isUnsafe(bleeds, Question::begin, true));
    EXPECT_FALSE(isUnsafe(bleeds, Question::begin, false));
    EXPECT_FALSE(isUnsafe(well, Question::clotting, true));
    EXPECT_TRUE(isUnsafe(well, Question::antibiotic, false));
    EXPECT_FALSE(isUnsafe(well, Question::begin, false)) << "a delay, no danger";
    EXPECT_TRUE(isUnsafe(shock, Question::begin, false)) << "the shock does not wait";
    EXPECT_FALSE(isUnsafe(shock, Question::begin, true));
}

// Neither yes nor no is always right, in no case.
TEST(PatientCase, NoCaseHasOneAnswerForAllQuestions) {
    for (const auto& entry : std::filesystem::directory_iterator(kCases)) {
        if (entry.path().extension() != ".toml") continue;
        const std::string answers = answersOf(loadCase(entry.path()));
        EXPECT_NE(answers.find('y'), std::string::npos) << entry.path();
        EXPECT_NE(answers.find('n'), std::string::npos) << entry.path();
    }
}

TEST(PatientCase, ReasonNamesValueLimitAndSource) {
    EXPECT_EQ(describeAnswer(shipped("raised-inr"), Question::clotting, false),
              "Must the clotting be corrected? No: wrong, the INR of 2.4 is above 1.8 (SIR 2019)");
    EXPECT_EQ(describeReason(shipped("apixaban"), Question::thinner),
              "apixaban must have been stopped for 72 h, and was for 54 h (SIR 2019)");
}

// A shipped case with one text replaced is refused, and the error names the field. `by` is a text that
// the file contains.
void expectRefused(const std::string& name, const std::string& by, const std::string& to,
                   const std::string& field) {
    std::string toml = test::readText(kCases / (name + ".toml"));
    const std::size_t at = toml.find(by);
    ASSERT_NE(at, std::string::npos) << by;
    toml.replace(at, by.size(), to);
    test::expectRefused([&] { (void)parseCase(toml, "case.toml"); }, "case.toml", field);
}

// HZ-RECORD-14
TEST(PatientCase, CaseThatMakesNoSenseIsRefused) {
    expectRefused("clean", "inr = 1.1", "inr = 0.1", "blood.inr");
    expectRefused("clean", "inr = 1.1", "inr = nan", "blood.inr");
    expectRefused("clean", "inr = 1.1", "inr = \"1.1\"", "blood.inr");
    expectRefused("clean", "inr = 1.1\n", "", "blood.inr: missing");
    expectRefused("clean", "[blood]", "[lymph]", "blood: missing");
    expectRefused("clean", "age_years = 67", "age_years = 6", "age_years");
    expectRefused("clean", "age_years = 67", "age_years = 1e300", "age_years");
    expectRefused("clean", "sex = \"female\"", "sex = \"none\"", "sex");
    expectRefused("clean", "title = \"", "title = \"\" #", "title");
    expectRefused("clean", "title = \"", "title = \"" + std::string(101, 'x'), "title");
    expectRefused("clean", "consent = \"given\"", "consent = \"presumed\"", "consent: is presumed only");
    expectRefused("septic-shock", "consent = \"presumed\"", "consent = \"missing\"",
                  "consent: in an emergency");
    expectRefused("clean", "blood_thinner = \"none\"", "blood_thinner = \"none\"\nlast_dose_h = 3",
                  "last_dose_h: there is no blood thinner");
    expectRefused("apixaban", "last_dose_h = 54\n", "", "last_dose_h: missing");
    expectRefused("apixaban", "antibiotic_min = 25", "antibiotic_min = -1", "antibiotic_min");
    expectRefused("clean", "age_years = 67", "age_years = 67\nage_years = 68", "");
    EXPECT_THROW((void)parseCase(std::string(9000, '#'), "case.toml"), DataError);
    EXPECT_THROW((void)parseCase("", "case.toml"), DataError);
}

// A file has facts only. It cannot allow what the facts forbid.
TEST(PatientCase, FileCannotNameAnAnswer) {
    for (const char* answer : {"begin = true", "clotting = false", "answers = \"nnnnnny\""})
        expectRefused("raised-inr", "age_years", std::string(answer) + "\nage_years",
                      std::string(answer).substr(0, std::string(answer).find(' ')));
}

}  // namespace
}  // namespace stylet::training
