#include <fmt/core.h>
#include <chrono>
#include <memory>

#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/print.h"

namespace stylet::modeller {

namespace {

struct SynthOptions {
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;
    int threads = 2;
    std::string out;
};

void synth(const SynthOptions& o) {
    const auto begin = std::chrono::steady_clock::now();
    const patient::Package package = referencePatient(o.seed, o.spacing_mm, o.threads);
    patient::savePackage(package, o.out);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    const Index3 d = package.ct.grid.dims;
    printResult("{}: {} x {} x {} voxels in {}, digest {:x}, {:g} s\n", package.name, d.x, d.y, d.z, o.out,
                patient::digest(package), took.count());
}

}  // namespace

void addSynth(CLI::App& app) {
    const auto o = std::make_shared<SynthOptions>();
    CLI::App* command = app.add_subcommand("synth", "Make a reference patient from a seed.");
    command->add_option("--seed", o->seed, "Seed of the patient; the same seed gives the same bytes.")
        ->check([](const std::string& text) { return text.starts_with('-') ? text + " is negative" : ""; })
        ->capture_default_str();
    command->add_option("--out", o->out, "Folder for the package.")->required();
    command->add_option("--spacing-mm", o->spacing_mm, "Voxel size [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    command->add_option("--threads", o->threads, "Number of threads; it does not change the result.")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command->callback([o] { synth(*o); });
}

}  // namespace stylet::modeller
