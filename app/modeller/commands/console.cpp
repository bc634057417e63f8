#include "app/modeller/commands/console.h"

#include <unistd.h>

#include <cstdio>

#include "app/installation.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

std::function<void(std::string_view, double)> progressBar(std::string title) {
    const bool terminal = isatty(fileno(stderr)) != 0;
    return [title = std::move(title), terminal](std::string_view stage, double fraction) {
        constexpr int kWidth = 30;
        const int full = int(fraction * kWidth + 0.5);
        const std::string bar =
            std::string(std::size_t(full), '#') + std::string(std::size_t(kWidth - full), '.');
        std::fprintf(stderr, "%s%s [%s] %3d %%  %-12.*s%s", terminal ? "\r" : "", title.c_str(), bar.c_str(),
                     int(fraction * 100.0 + 0.5), int(stage.size()), stage.data(),
                     terminal && fraction < 1.0 ? "" : "\n");
        std::fflush(stderr);
    };
}

patient::TissueDefaults tissueDefaults() {
    return patient::loadTissueDefaults(assetsFolder() / "tissue" / "ptcd.toml");
}

patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads) {
    patient::synth::SynthSettings settings;
    settings.seed = seed;
    settings.spacing_m = spacing_mm / 1000.0;
    settings.defaults = tissueDefaults();
    settings.threads = threads;
    settings.progress = progressBar("seed " + std::to_string(seed));
    return patient::synth::makeReferencePatient(settings);
}

}  // namespace stylet::modeller
