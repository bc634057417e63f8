#include <fmt/core.h>
#include <chrono>
#include <memory>

#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/options.h"
#include "app/print.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

namespace {

struct SynthOptions {
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;
    int threads = 2;
    std::string out;
    std::vector<std::string> variants;
};

void printVariants() {
    for (const patient::synth::VariantInfo& v : patient::synth::listVariants())
        printResult("{:<20} {} ({})\n", v.name, v.changes, v.source);
}

void synth(const SynthOptions& o) {
    if (o.variants == std::vector<std::string>{"list"}) return printVariants();
    if (o.out.empty()) throw CLI::RequiredError("--out");
    checkOut(o.out);
    const auto begin = std::chrono::steady_clock::now();
    const patient::Package package = referencePatient(o.seed, o.spacing_mm, o.threads, o.variants);
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
    command->add_option("--out", o->out, "Folder for the package.");
    command
        ->add_option("--variant", o->variants,
                     "Make a hard case of the patient: names, separated by commas. \"list\" prints them.")
        ->delimiter(',');
    command->add_option("--spacing-mm", o->spacing_mm, "Voxel size [mm].")
        ->check(inRange(0.5, 5.0))
        ->capture_default_str();
    command->add_option("--threads", o->threads, "Number of threads; it does not change the result.")
        ->check(inRange(1, 64))
        ->capture_default_str();
    command->callback([o] {
        try {
            synth(*o);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError("--variant", e.what());
        }
    });
}

}  // namespace stylet::modeller
