#include "app/modeller/commands/console.h"

#include <unistd.h>

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <system_error>

#include "app/installation.h"
#include "app/print.h"
#include "base/path.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

std::function<void(std::string_view)> timedProgress() {
    using Clock = std::chrono::steady_clock;
    return [start = Clock::now()](std::string_view stage) {
        printProgress("{:6.1f} s  {}\n", std::chrono::duration<double>(Clock::now() - start).count(), stage);
    };
}

std::function<void(std::string_view, double)> progressBar(std::string title) {
    const bool terminal = isatty(fileno(stderr)) != 0;
    return [title = std::move(title), terminal](std::string_view stage, double fraction) {
        constexpr int kWidth = 30;
        const int full = int(fraction * kWidth + 0.5);
        const std::string bar = fmt::format("{:.<{}}", std::string(std::size_t(full), '#'), kWidth);
        printProgress("{}{} [{}] {:3} %  {:<12}{}", terminal ? "\r" : "", title, bar,
                      int(fraction * 100.0 + 0.5), stage, terminal && fraction < 1.0 ? "" : "\n");
        std::fflush(stderr);
    };
}

patient::TissueDefaults tissueDefaults() {
    return patient::loadTissueDefaults(assetsFolder() / "tissue" / "ptcd.toml");
}

void printPackage(const patient::Package& p, const std::filesystem::path& folder) {
    printResult("thresholds: {:.0f}, {:.0f}, {:.0f} (outside the fascia), {:.0f} (past it) HU\n",
                p.thresholds.t0_hu, p.thresholds.t1_hu, p.thresholds.t2_sensitive_hu,
                p.thresholds.t2_specific_hu);
    const Grid& g = p.ct.grid;
    printResult("{}: {} x {} x {} voxels of {:.2f} mm", folder.string(), g.dims.x, g.dims.y, g.dims.z,
                1e3 * g.spacing_m.x);
}

bool printVerdict(const patient::Package& p, const std::filesystem::path& folder,
                  const std::vector<Finding>& findings) {
    patient::CheckVerdict verdict{patient::digest(p), anyRefused(findings), {}};
    if (findings.empty()) printResult("{}: plausible\n", p.name);
    for (const Finding& f : findings) {
        verdict.findings.push_back(formatFinding(f));
        printResult("{}\n", verdict.findings.back());
    }
    try {
        patient::saveVerdict(verdict, folder);
    } catch (const DataError& e) {
        // An older verdict may still accept the package.
        printProgress("stylet-model: the verdict was not stored: {}\n", e.what());
        return false;
    }
    return !verdict.refused;
}

void checkOut(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs) {
    patient::checkPackageFolder(out);
    const auto resolved = [](const std::filesystem::path& path) {
        std::error_code error;
        std::filesystem::path whole = weakly_canonical(absolute(path), error);
        if (error) whole = absolute(path).lexically_normal();
        return withoutSlash(whole);
    };
    const std::filesystem::path folder = resolved(out);
    for (const std::filesystem::path& input : inputs) {
        if (input.empty()) continue;
        const std::filesystem::path inner = resolved(input);
        if (std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end()).first == folder.end())
            throw DataError(out, "--out",
                            "would replace " + input.string() + ", which is read; choose another folder");
    }
}

patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads,
                                  const std::vector<std::string>& variants) {
    patient::synth::SynthSettings settings;
    settings.seed = seed;
    settings.spacing_m = spacing_mm / 1000.0;
    settings.defaults = tissueDefaults();
    settings.threads = threads;
    settings.variants = variants;
    settings.progress = progressBar("seed " + std::to_string(seed));
    return patient::synth::makeReferencePatient(settings);
}

}  // namespace stylet::modeller
