#include "app/training/patient_case.h"

#include <fmt/core.h>

#include "base/fields.h"
#include "base/text.h"
#include "base/whole_file.h"

namespace stylet::training {

namespace {

// With texts of these lengths the case fits the notice that shows it (app/trainer/view/notice.h).
constexpr std::size_t kMaxCaseBytes = 1 << 13, kMaxTitleBytes = 70, kMaxFindingBytes = 70,
                      kMaxAllergiesBytes = 40;

constexpr std::array<std::string_view, 2> kSexNames{"female", "male"};
constexpr std::array<std::string_view, 3> kUrgencyNames{"elective", "urgent", "emergency"};
constexpr std::array<std::string_view, 3> kAscitesNames{"none", "small", "large"};
constexpr std::array<std::string_view, 3> kReactionNames{"none", "mild", "severe"};
constexpr std::array<std::string_view, 3> kConsentNames{"given", "presumed", "missing"};
constexpr std::array<std::string_view, 7> kThinnerNames{"none",     "aspirin",    "clopidogrel", "warfarin",
                                                        "apixaban", "dabigatran", "enoxaparin"};

constexpr std::array<std::string_view, kQuestionCount> kQuestionTexts{
    "Must the clotting be corrected?",
    "Must the effect of a blood thinner be waited out or reversed?",
    "Must the ascites be drained before the puncture?",
    "Does the contrast medium need precautions (another agent, premedication)?",
    "Must consent still be obtained?",
    "Must an antibiotic be given now?",
    "May the drainage begin at once, without waiting for any of this?"};

double maxInr(const PatientCase& c) noexcept {
    return c.liver_disease ? kMaxInrLiver : kMaxInr;
}
double minPlatelets_e9_per_l(const PatientCase& c) noexcept {
    return c.liver_disease ? kMinPlateletsLiver_e9_per_l : kMinPlatelets_e9_per_l;
}

// Hours without the medicine before a procedure of high bleeding risk. Warfarin is judged by the INR.
double holdTime_h(const PatientCase& c) noexcept {
    const bool slow = c.egfr_ml_per_min < kSlowKidney_ml_per_min;
    switch (c.thinner) {
        case Thinner::none:
        case Thinner::warfarin:
            return 0.0;
        case Thinner::aspirin:
            return 72.0;
        case Thinner::clopidogrel:
            return 120.0;
        case Thinner::apixaban:
            return slow ? 72.0 : 48.0;
        case Thinner::dabigatran:
            return slow ? 96.0 : 48.0;
        case Thinner::enoxaparin:
            return 24.0;
    }
    return 0.0;
}

bool needsClotting(const PatientCase& c) noexcept {
    return c.inr > maxInr(c) || c.platelets_e9_per_l < minPlatelets_e9_per_l(c);
}
bool needsWait(const PatientCase& c) noexcept {
    return c.thinner == Thinner::warfarin ? c.inr > maxInr(c) : c.last_dose_h < holdTime_h(c);
}
bool needsAntibiotic(const PatientCase& c) noexcept {
    return !c.antibiotic_min || *c.antibiotic_min > kAntibioticLasts_min;
}
// Everything that takes time. An antibiotic does not.
bool mustWait(const PatientCase& c) noexcept {
    return needsClotting(c) || needsWait(c) || c.ascites == Ascites::large ||
           c.reaction == Reaction::severe || c.consent == Consent::missing;
}

std::string clottingReason(const PatientCase& c) {
    const std::string whose = c.liver_disease ? " in chronic liver disease" : "";
    if (c.inr > maxInr(c))
        return fmt::format("the INR of {:g} is above {:g}{} (SIR 2019)", c.inr, maxInr(c), whose);
    if (needsClotting(c))
        return fmt::format("{:g} x 10⁹/l platelets are fewer than {:g}{} (SIR 2019)", c.platelets_e9_per_l,
                           minPlatelets_e9_per_l(c), whose);
    return fmt::format("{}INR {:g} and {:g} x 10⁹/l platelets suffice (SIR 2019)",
                       c.liver_disease ? "in liver disease " : "", maxInr(c), minPlatelets_e9_per_l(c));
}

std::string thinnerReason(const PatientCase& c) {
    if (c.thinner == Thinner::none) return "no blood thinner is taken";
    const std::string_view name = enumName(kThinnerNames, c.thinner);
    if (c.thinner == Thinner::warfarin)
        return fmt::format("warfarin acts while the INR is above {:g}, and it is {:g} (SIR 2019)", maxInr(c),
                           c.inr);
    return fmt::format("{} must have been stopped for {:g} h, and was for {:g} h (SIR 2019)", name,
                       holdTime_h(c), c.last_dose_h);
}

std::string contrastReason(const PatientCase& c) {
    if (c.reaction == Reaction::severe)
        return "after a severe reaction: another agent and premedication (ACR 2025)";
    if (c.reaction == Reaction::mild) return "after a mild reaction: another agent (ACR 2025)";
    return "no other allergy counts, only a reaction to such a medium (ACR 2025)";
}

std::string beginReason(const PatientCase& c) {
    if (c.urgency == Urgency::emergency)
        return "in an emergency delay is the greater risk: correct meanwhile (CIRSE 2021)";
    return mustWait(c) ? "what takes time comes first (CIRSE 2021)"
                       : "nothing has to be waited for; an antibiotic takes no time";
}

void readBlood(Fields in, PatientCase& c) {
    c.inr = in.number("inr", 0.8, 15.0);
    c.platelets_e9_per_l = in.number("platelets_e9_per_l", 1.0, 1500.0);
    c.bilirubin_umol_per_l = in.number("bilirubin_umol_per_l", 1.0, 1000.0);
    c.crp_mg_per_l = in.number("crp_mg_per_l", 0.0, 1000.0);
    c.egfr_ml_per_min = in.number("egfr_ml_per_min", 2.0, 150.0);
    in.finish();
}

}  // namespace

std::string_view questionText(Question question) noexcept {
    return enumName(kQuestionTexts, question);
}

bool rightAnswer(const PatientCase& c, Question question) noexcept {
    switch (question) {
        case Question::clotting:
            return needsClotting(c);
        case Question::thinner:
            return needsWait(c);
        case Question::ascites:
            return c.ascites == Ascites::large;
        case Question::contrast:
            return c.reaction != Reaction::none;
        case Question::consent:
            return c.consent == Consent::missing;
        case Question::antibiotic:
            return needsAntibiotic(c);
        case Question::begin:
            return c.urgency == Urgency::emergency || !mustWait(c);
    }
    return false;
}

std::string describeReason(const PatientCase& c, Question question) {
    switch (question) {
        case Question::clotting:
            return clottingReason(c);
        case Question::thinner:
            return thinnerReason(c);
        case Question::ascites:
            return c.ascites == Ascites::large
                       ? "much ascites lets blood and bile leak from the liver (CIRSE 2021)"
                       : "only much ascites is drained first (CIRSE 2021)";
        case Question::contrast:
            return contrastReason(c);
        case Question::consent:
            return c.consent == Consent::missing ? "nobody is treated without consent (CIRSE 2021)"
                   : c.consent == Consent::given
                       ? "consent was given"
                       : "in an emergency the consent of an unconscious patient is presumed";
        case Question::antibiotic:
            return needsAntibiotic(c)
                       ? fmt::format("every biliary drainage needs one within {:g} min before it (SIR 2018)",
                                     kAntibioticLasts_min)
                       : fmt::format("it was given within the last {:g} min (SIR 2018)",
                                     kAntibioticLasts_min);
        case Question::begin:
            return beginReason(c);
    }
    return "";
}

bool isUnsafe(const PatientCase& c, Question question, bool answer) noexcept {
    if (answer == rightAnswer(c, question)) return false;
    return question == Question::begin ? answer || c.urgency == Urgency::emergency : !answer;
}

std::string describeAnswer(const PatientCase& c, Question question, bool answer) {
    return fmt::format("{} {}: {}, {}", questionText(question), answer ? "Yes" : "No",
                       answer == rightAnswer(c, question) ? "right" : "wrong", describeReason(c, question));
}

std::vector<std::string> describeCase(const PatientCase& c) {
    std::vector<std::string> lines{
        fmt::format("{}. {}, {} years, {}.", c.title, c.sex == Sex::female ? "Woman" : "Man", c.age_years,
                    enumName(kUrgencyNames, c.urgency)),
        c.finding + ".",
        fmt::format("INR {:g}, platelets {:g} x 10⁹/l, eGFR {:g} ml/min.", c.inr, c.platelets_e9_per_l,
                    c.egfr_ml_per_min),
        fmt::format("Bilirubin {:g} µmol/l, CRP {:g} mg/l, {:.1f} °C.", c.bilirubin_umol_per_l,
                    c.crp_mg_per_l, c.temperature_c),
        fmt::format("Chronic liver disease: {}. Ascites: {}.", c.liver_disease ? "yes" : "no",
                    enumName(kAscitesNames, c.ascites)),
        fmt::format("Earlier reaction to contrast medium: {}. Other allergies: {}.",
                    enumName(kReactionNames, c.reaction),
                    c.other_allergies.empty() ? "none" : c.other_allergies)};
    lines.push_back(c.thinner == Thinner::none
                        ? "Blood thinner: none."
                        : fmt::format("Blood thinner: {}, last dose {:g} h ago.",
                                      enumName(kThinnerNames, c.thinner), c.last_dose_h));
    lines.push_back(fmt::format(
        "Antibiotic: {}. Consent: {}.",
        c.antibiotic_min ? fmt::format("given {:g} min ago", *c.antibiotic_min) : std::string("none given"),
        enumName(kConsentNames, c.consent)));
    return lines;
}

PatientCase loadCase(const std::filesystem::path& toml) {
    return parseCase(readWholeFile(toml, kMaxCaseBytes), toml);
}

PatientCase parseCase(std::string_view toml, const std::filesystem::path& file) {
    if (toml.size() > kMaxCaseBytes) throw DataError(file, "file", "is larger than a case may be");
    Fields top = parseToml(file, toml);
    PatientCase c;
    c.title = top.nonEmptyText("title", kMaxTitleBytes);
    c.finding = top.nonEmptyText("finding", kMaxFindingBytes);
    c.age_years = int(top.integer("age_years", 18, 120));
    c.sex = top.choice<Sex>("sex", kSexNames);
    c.urgency = top.choice<Urgency>("urgency", kUrgencyNames);
    c.temperature_c = top.number("temperature_c", 30.0, 43.0);
    readBlood(top.child("blood"), c);
    c.liver_disease = top.flag("liver_disease");
    c.ascites = top.choice<Ascites>("ascites", kAscitesNames);
    c.reaction = top.choice<Reaction>("contrast_reaction", kReactionNames);
    c.other_allergies = top.textOr("other_allergies", "", kMaxAllergiesBytes);
    c.thinner = top.choice<Thinner>("blood_thinner", kThinnerNames);
    if (c.thinner == Thinner::none && top.has("last_dose_h"))
        top.refuse("last_dose_h", "there is no blood thinner");
    if (c.thinner != Thinner::none) c.last_dose_h = top.number("last_dose_h", 0.0, 1000.0);
    if (top.has("antibiotic_min")) c.antibiotic_min = top.number("antibiotic_min", 0.0, 10'000.0);
    c.consent = top.choice<Consent>("consent", kConsentNames);
    // Otherwise two right answers would contradict each other.
    if (c.consent == Consent::missing && c.urgency == Urgency::emergency)
        top.refuse("consent", "in an emergency it is given or presumed");
    if (c.consent == Consent::presumed && c.urgency != Urgency::emergency)
        top.refuse("consent", "is presumed only in an emergency");
    top.finish();
    c.toml = toml;
    return c;
}

}  // namespace stylet::training
