#include <fmt/core.h>
#include <cstdio>
#include <map>
#include <memory>

#include "app/modeller/check/check_package.h"
#include "app/modeller/check/findings.h"
#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/options.h"
#include "app/print.h"
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
    return fmt::format("{:.4g} .. {:.4g}", l.low, l.high);
}

void printLine(const CheckLine& l) {
    printResult("  {:<4} {:<42} {:10.2f} {:<6} [{}]\n", l.ok() ? "ok" : "FAIL", l.name, l.value, l.unit,
                bounds(l));
}

bool printReferenceChecks(const patient::Package& package) {
    bool ok = true;
    printResult("{}\n", package.name);
    for (const CheckLine& l : patient::synth::checkPatient(package)) {
        printLine(l);
        ok = ok && l.ok();
    }
    return ok;
}

// Prints one line per measure, with its range over the reference patients of the seeds.
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
            printResult("seed {}: {} is {:.2f} {}, allowed {}\n", seed, lines[i].name, lines[i].value,
                        lines[i].unit, bounds(lines[i]));
        }
    }
    printResult("seeds {} to {} at {:.1f} mm\n", first, last, spacing_mm);
    for (const Range& r : ranges)
        printResult("  {:<4} {:<42} {:10.2f} to {:10.2f} {:<6} [{}]\n", r.failed == 0 ? "ok" : "FAIL",
                    r.line.name, r.low, r.high, r.line.unit, bounds(r.line));
    return ok;
}

// Prints and stores the findings of a package. A reference patient is also measured against its own ranges.
// Coarse voxels leave these ranges too, so values outside are warnings.
bool printFindings(const std::string& folder, int threads) {
    const patient::Package package = patient::loadPackage(folder);
    Findings findings;
    findings.list = checkPackage(package, threads);
    std::vector<CheckLine> lines;
    if (patient::synth::isReferencePatient(package)) lines = patient::synth::checkPatient(package);
    for (const CheckLine& l : lines)
        findings.expect(Findings::warned, l.name, l.value, l.unit, {l.low, l.high},
                        "the range holds for a reference patient with voxels of 1 mm: these are coarser, or "
                        "CT or labels were "
                        "changed; make the patient again with 1 mm");
    const bool plausible = printVerdict(package, folder, findings.list);
    for (const CheckLine& l : lines)
        if (l.ok()) printLine(l);
    return plausible;
}

bool check(const CheckOptions& o) {
    if (o.seeds.empty()) return printFindings(o.patient, o.threads);
    unsigned long long first = 0, last = 0;
    const int got = std::sscanf(o.seeds.c_str(), "%llu..%llu", &first, &last);
    if (got < 1 || (got == 2 && last < first)) throw CLI::ValidationError("--seeds", "expected A..B or A");
    if (got == 1) return printReferenceChecks(referencePatient(first, o.spacing_mm, o.threads));
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
        ->check(inRange(0.5, 5.0));
    command->add_option("--threads", o->threads, "Number of threads; it does not change the result.")
        ->check(inRange(1, 64))
        ->capture_default_str();
    command->callback([o] {
        if (o->patient.empty() && o->seeds.empty()) throw CLI::RequiredError("a patient's folder or --seeds");
        if (!check(*o)) throw CLI::RuntimeError(1);
    });
}

}  // namespace stylet::modeller
