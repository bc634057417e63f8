#include "patient/package/verdict.h"

#include <nlohmann/json.hpp>

#include "base/fields.h"
#include "base/hash.h"
#include "base/hex.h"
#include "base/whole_file.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVerdictName = "verdict.json";
constexpr const char* kVerdictFormat = "stylet verdict 1";
constexpr std::size_t kMaxVerdictBytes = 1 << 20, kMaxFindings = 1000, kMaxFindingBytes = 4000;

std::uint64_t checksum(const CheckVerdict& verdict) {
    StateHash hash;
    hash.add(std::string_view(kVerdictFormat));
    hash.add(verdict.patient_digest);
    hash.add(std::uint64_t(verdict.refused));
    hash.add(std::uint64_t(verdict.findings.size()));
    for (const std::string& finding : verdict.findings)
        hash.add(std::string_view(finding));
    return hash.value();
}

struct Complaint {
    std::string field, reason;
};

// Why the verdict forbids the use of the package, or nothing.
std::optional<Complaint> complaint(const Package& package, const CheckVerdict& verdict) {
    if (verdict.patient_digest != digest(package))
        return Complaint{"patient_digest", "the patient was changed after its check"};
    if (verdict.refused)
        return Complaint{"refused",
                         "the check refused this patient: " +
                             (verdict.findings.empty() ? "no reason stored" : verdict.findings.front())};
    return std::nullopt;
}

}  // namespace

CheckVerdict parseVerdict(const fs::path& file, std::string_view text) {
    Fields in = parseJson(file, text);
    if (in.text("format", 100) != kVerdictFormat)
        in.refuse("format", std::string("not \"") + kVerdictFormat + "\"");
    CheckVerdict verdict;
    verdict.patient_digest = in.hex("patient_digest");
    verdict.refused = in.flag("refused");
    verdict.findings = in.texts("findings", kMaxFindings, kMaxFindingBytes);
    if (in.hex("checksum") != checksum(verdict))
        in.refuse("checksum", "the verdict was edited or is damaged");
    in.finish();
    return verdict;
}

void saveVerdict(const CheckVerdict& verdict, const fs::path& folder) {
    const nlohmann::ordered_json json{{"format", kVerdictFormat},
                                      {"patient_digest", hexText(verdict.patient_digest)},
                                      {"refused", verdict.refused},
                                      {"findings", verdict.findings},
                                      {"checksum", hexText(checksum(verdict))}};
    writeWholeFile(folder / kVerdictName, json.dump(1) + '\n');
}

std::optional<CheckVerdict> loadVerdict(const fs::path& folder) {
    const fs::path file = folder / kVerdictName;
    if (!fs::exists(file)) return std::nullopt;
    return parseVerdict(file, readWholeFile(file, kMaxVerdictBytes));
}

std::string requirePlausible(const Package& package, const fs::path& folder, bool accept_implausible) {
    const fs::path file = folder / kVerdictName;
    try {
        const std::optional<CheckVerdict> verdict = loadVerdict(folder);
        if (!verdict) return std::string(kNotChecked);
        const std::optional<Complaint> c = complaint(package, *verdict);
        if (!c) return "";
        if (accept_implausible) return "overruled: " + c->reason;
        throw DataError(file, c->field,
                        c->reason + ". Correct the patient and run `stylet-model check " + folder.string() +
                            "`, or overrule it with --accept-implausible");
    } catch (const DataError& e) {  // an edited or damaged verdict
        if (!accept_implausible) throw;
        return std::string("overruled: ") + e.what();
    }
}

}  // namespace stylet::patient
