#include <cstdio>
#include <map>
#include <memory>

#include "app/modeller/check/check_package.h"
#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

namespace {

using patient::synth::CheckLine;

struct CheckOptions {
    std::string patient, seeds;
    double spacing_mm = 1.0;
    int threads = 2;
};

std::string bounds(const CheckLine& l) {
    char text[64];
    std::snprintf(text, sizeof text, "%.4g .. %.4g", l.low, l.high);
    return text;
}

bool printOne(const patient::Package& package) {
    bool ok = true;
    std::printf("%s\n", package.name.c_str());
    for (const CheckLine& l : patient::synth::checkPatient(package)) {
        std::printf("  %-4s %-42s %10.2f %-6s [%s]\n", l.ok() ? "ok" : "FAIL", l.name.c_str(), l.value,
                    l.unit.c_str(), bounds(l).c_str());
        ok = ok && l.ok();
    }
    return ok;
}

// One line per measure, with its range over the seeds.
bool printCohort(std::uint64_t first, std::uint64_t last, double spacing_mm, int threads) {
    struct Range {
        CheckLine line;
        double low, high;
        int failed;
    };
    std::vector<Range> ranges;
    bool ok = true;
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        const std::vector<CheckLine> lines =
            patient::synth::checkPatient(referencePatient(seed, spacing_mm, threads));
        if (ranges.empty())
            for (const CheckLine& l : lines)
                ranges.push_back({l, l.value, l.value, 0});
        for (std::size_t i = 0; i < lines.size(); ++i) {
            ranges[i].low = std::min(ranges[i].low, lines[i].value);
            ranges[i].high = std::max(ranges[i].high, lines[i].value);
            if (lines[i].ok()) continue;
            ++ranges[i].failed;
            ok = false;
            std::printf("seed %llu: %s is %.2f %s, allowed %s\n", static_cast<unsigned long long>(seed),
                        lines[i].name.c_str(), lines[i].value, lines[i].unit.c_str(),
                        bounds(lines[i]).c_str());
        }
    }
    std::printf("seeds %llu to %llu at %.1f mm\n", static_cast<unsigned long long>(first),
                static_cast<unsigned long long>(last), spacing_mm);
    for (const Range& r : ranges)
        std::printf("  %-4s %-42s %10.2f to %10.2f %-6s [%s]\n", r.failed == 0 ? "ok" : "FAIL",
                    r.line.name.c_str(), r.low, r.high, r.line.unit.c_str(), bounds(r.line).c_str());
    return ok;
}

// Prints the findings of a package. A reference patient is also checked against its own ranges.
bool printPackage(const patient::Package& package, int threads) {
    const std::vector<Finding> findings = checkPackage(package, threads);
    if (findings.empty()) std::printf("%s: plausible\n", package.name.c_str());
    for (const Finding& f : findings)
        std::printf("%s\n", lineOf(f).c_str());
    const bool plausible = !anyRefused(findings);
    return (!patient::synth::isReferencePatient(package) || printOne(package)) && plausible;
}

bool check(const CheckOptions& o) {
    if (o.seeds.empty()) return printPackage(patient::loadPackage(o.patient), o.threads);
    unsigned long long first = 0, last = 0;
    const int got = std::sscanf(o.seeds.c_str(), "%llu..%llu", &first, &last);
    if (got < 1 || (got == 2 && last < first)) throw CLI::ValidationError("--seeds", "expected A..B or A");
    if (got == 1) return printOne(referencePatient(first, o.spacing_mm, o.threads));
    return printCohort(first, last, o.spacing_mm, o.threads);
}

}  // namespace

void addCheck(CLI::App& app) {
    const auto o = std::make_shared<CheckOptions>();
    CLI::App* command = app.add_subcommand(
        "check",
        "List what is implausible in a patient. Measure a reference patient against its expected ranges.");
    auto* folder = command->add_option("patient", o->patient, "Folder of the package.");
    auto* seeds =
        command->add_option("--seeds", o->seeds, "A..B: check reference patients of these seeds instead.")
            ->excludes(folder);
    command->add_option("--spacing-mm", o->spacing_mm, "Voxel size of these reference patients [mm].")
        ->needs(seeds)
        ->check(CLI::Range(0.5, 5.0));
    command->add_option("--threads", o->threads, "Number of threads; it does not change the result.")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command->callback([o] {
        if (o->patient.empty() && o->seeds.empty()) throw CLI::RequiredError("a patient's folder or --seeds");
        if (!check(*o)) throw CLI::RuntimeError(1);
    });
}

}  // namespace stylet::modeller
