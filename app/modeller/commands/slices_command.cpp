#include <iostream>
#include <memory>
#include <optional>

#include "app/modeller/check/slices.h"
#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"

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
    CLI::App* command = app.add_subcommand("slices", "pictures of a patient's slices, plain and with labels");
    auto* folder = command->add_option("patient", o->patient, "folder of the package");
    auto* seed =
        command->add_option("--seed", o->seed, "a reference patient instead of a folder")->excludes(folder);
    command->add_option("--spacing-mm", o->spacing_mm, "its voxel size")
        ->needs(seed)
        ->check(CLI::Range(0.5, 5.0));
    command->add_option("--out", o->out, "folder of the PNGs")->required();
    command->callback([o] {
        if (!o->seed && o->patient.empty()) throw CLI::RequiredError("a patient's folder or --seed");
        writeSlices(o->seed ? referencePatient(*o->seed, o->spacing_mm, 2) : patient::loadPackage(o->patient),
                    o->out);
        std::cout << "slices in " << o->out << '\n';
    });
}

}  // namespace stylet::modeller
