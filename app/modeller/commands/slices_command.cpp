#include <fmt/core.h>
#include <memory>
#include <optional>

#include "app/modeller/check/slices.h"
#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/options.h"
#include "app/print.h"
#include "base/folder_linux.h"

namespace stylet::modeller {

namespace {

struct SlicesOptions {
    std::string patient, out;
    std::optional<std::uint64_t> seed;
    double spacing_mm = 1.0;
};

}  // namespace

void addSlices(CLI::App& app) {
    const auto o = std::make_shared<SlicesOptions>();
    CLI::App* command = app.add_subcommand("slices", "Draw slices of a patient, with and without labels.");
    auto* folder = command->add_option("patient", o->patient, "Folder of the package.");
    auto* seed = command->add_option("--seed", o->seed, "Seed of a reference patient, instead of a package.")
                     ->excludes(folder);
    command->add_option("--spacing-mm", o->spacing_mm, "Voxel size of this reference patient [mm].")
        ->needs(seed)
        ->check(inRange(0.5, 5.0));
    command->add_option("--out", o->out, "Folder for the PNG files.")->required();
    command->callback([o] {
        if (!o->seed && o->patient.empty()) throw CLI::RequiredError("a patient's folder or --seed");
        requireFolder(o->out, "--out");
        writeSlices(o->seed ? referencePatient(*o->seed, o->spacing_mm, 2) : patient::loadPackage(o->patient),
                    o->out);
        printResult("slices in {}\n", o->out);
    });
}

}  // namespace stylet::modeller
