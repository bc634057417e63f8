#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "app/modeller/commands.h"
#include "app/modeller/console.h"
#include "app/modeller/film.h"

namespace stylet::modeller {

namespace {

struct Options {
    std::string patient, out, signal;
    std::optional<std::uint64_t> seed;
    std::optional<double> seconds;
    double spacing_mm = 1.0;
    int frames = 24;
};

// The dome against the signal, a bar a frame.
void printDome(const Film& film) {
    double most_m = 1e-6;
    for (const FilmMoment& moment : film.moments)
        most_m = std::max(most_m, moment.dome_m);
    std::cout << " t [s]      v   dome [mm]\n";
    for (const FilmMoment& moment : film.moments) {
        char line[80];
        std::snprintf(line, sizeof line, "%6.2f %6.3f %8.2f  ", moment.t_s, moment.breath.v,
                      1e3 * moment.dome_m);
        std::cout << line << std::string(std::size_t(std::max(0.0, 40.0 * moment.dome_m / most_m)), '#')
                  << '\n';
    }
}

}  // namespace

void addFilm(CLI::App& app) {
    const auto o = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("film", "a breath in coronal slices, and the dome against the signal");
    auto* folder = command->add_option("patient", o->patient, "folder of the package");
    auto* seed =
        command->add_option("--seed", o->seed, "a reference patient instead of a folder")->excludes(folder);
    command->add_option("--spacing-mm", o->spacing_mm, "its voxel size")
        ->needs(seed)
        ->check(CLI::Range(0.5, 5.0));
    command->add_option("--frames", o->frames, "pictures")->check(CLI::Range(1, 1000))->capture_default_str();
    command->add_option("--seconds", o->seconds, "of the film; default: one breath")
        ->check(CLI::Range(0.1, 600.0));
    command->add_option("--signal", o->signal, "a recorded breath (CSV) instead of the patient's own rhythm");
    command->add_option("--out", o->out, "folder of the PNGs")->required();
    command->callback([o] {
        if (!o->seed && o->patient.empty()) throw CLI::RequiredError("a patient's folder or --seed");
        const patient::Package package =
            o->seed ? referencePatient(*o->seed, o->spacing_mm, 2) : patient::loadPackage(o->patient);
        patient::BreathPlan plan{.rhythm = package.signal};
        double breath_s = package.signal.period_s;
        if (!o->signal.empty()) {
            const patient::RecordedBreath recorded = patient::loadRecordedBreath(o->signal);
            plan.recording_v = recorded.v;
            plan.recording_dt_s = recorded.dt_s;
            breath_s = recorded.period_s;
        }
        const Film film = planFilm(package, plan, o->frames, o->seconds.value_or(breath_s));
        writeFilm(package, film, o->out);
        printDome(film);
        std::cout << "film in " << o->out << '\n';
    });
}

}  // namespace stylet::modeller
