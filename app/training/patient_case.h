// The case of a drainage: the facts about the patient that are reviewed before the body is opened. The right
// answers are computed from these facts by published limits, so a file cannot contradict them. One case is
// one file of assets/cases; its README lists the fields.
//
// Based on Patel et al., SIR consensus guidelines on periprocedural thrombotic and bleeding risk, JVIR
// 30:1168, 2019 (biliary interventions: high bleeding risk); Chehab et al., SIR practice parameter on
// antibiotic prophylaxis, JVIR 29:1483, 2018; Das et al., CIRSE standards on biliary drainage, CVIR 44:1499,
// 2021; Wang et al., ACR and AAAAI consensus on reactions to contrast media, 2025.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stylet::training {

enum class Sex : std::uint8_t { female, male };
// emergency: a delay is the greater risk
enum class Urgency : std::uint8_t { elective, urgent, emergency };
enum class Ascites : std::uint8_t { none, small, large };
enum class Reaction : std::uint8_t { none, mild, severe };
enum class Consent : std::uint8_t { given, presumed, missing };
enum class Thinner : std::uint8_t { none, aspirin, clopidogrel, warfarin, apixaban, dabigatran, enoxaparin };

inline constexpr double kMaxInr = 1.8, kMinPlatelets_e9_per_l = 50.0;
// In chronic liver disease, where both values look worse than the patient bleeds.
inline constexpr double kMaxInrLiver = 2.5, kMinPlateletsLiver_e9_per_l = 30.0;
inline constexpr double kAntibioticLasts_min = 60.0;
inline constexpr double kSlowKidney_ml_per_min = 50.0;  // below it, apixaban and dabigatran last longer

struct PatientCase {
    std::string title, finding;
    int age_years = 0;
    Sex sex = Sex::female;
    Urgency urgency = Urgency::elective;
    double temperature_c = 0.0, inr = 0.0, platelets_e9_per_l = 0.0, bilirubin_umol_per_l = 0.0,
           crp_mg_per_l = 0.0, egfr_ml_per_min = 0.0;
    bool liver_disease = false;  // chronic
    Ascites ascites = Ascites::none;
    Reaction reaction = Reaction::none;  // to an iodinated contrast medium, earlier
    std::string other_allergies;         // may be empty; they change no answer
    Thinner thinner = Thinner::none;
    double last_dose_h = 0.0;                // hours ago, unless the thinner is `none`
    std::optional<double> antibiotic_min{};  // minutes ago; absent: none was given
    Consent consent = Consent::given;
    std::string toml;  // text of the file, for records
};

// Asked in this order. All are answered by yes or no.
enum class Question : std::uint8_t { clotting, thinner, ascites, contrast, consent, antibiotic, begin };
inline constexpr int kQuestionCount = int(Question::begin) + 1;
std::string_view questionText(Question) noexcept;  // "Must the clotting be corrected?"

// True: yes.
bool rightAnswer(const PatientCase&, Question) noexcept;
// Why this is the right answer, with the limit and its source: "the INR of 2.4 is above 1.8 (SIR 2019)".
std::string describeReason(const PatientCase&, Question);
// True if this answer is wrong and endangers the patient: something necessary is left out, a drainage begins
// before it may, or an emergency waits. A needless correction is wrong too, but harmless.
bool isUnsafe(const PatientCase&, Question, bool answer) noexcept;

// "Must the clotting be corrected? No: wrong, the INR of 2.4 is above 1.8 (SIR 2019)"
std::string describeAnswer(const PatientCase&, Question, bool answer);

// All facts of the case, in short lines.
std::vector<std::string> describeCase(const PatientCase&);

// Throws DataError with file, field and reason.
PatientCase loadCase(const std::filesystem::path& toml);
// The same from the file's text. Errors name `file`.
PatientCase parseCase(std::string_view toml, const std::filesystem::path& file);

}  // namespace stylet::training
