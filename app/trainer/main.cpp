// The command line of `stylet`. A training simulator, not a medical device.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/trainer/calibrate.h"
#include "app/trainer/commands.h"
#include "app/trainer/curves.h"
#include "app/trainer/devices.h"
#include "app/trainer/film.h"
#include "app/trainer/palpate.h"
#include "app/trainer/replay.h"
#include "app/trainer/run.h"

namespace {

// Files and addresses that some devices need.
void addDeviceOptions(CLI::App& app, stylet::haptics::DeviceOptions& o) {
    app.add_option("--device-model", o.model, "woodenhaptics: the JSON file of its dimensions");
    app.add_option("--firmware", o.firmware, "falcon: the firmware image it is loaded with");
    app.add_option("--calibration", o.calibration, "falcon: its calibration of newtons per count");
    app.add_option("--device-force-n", o.force_peak_n, "inverse3: its largest force, from the data sheet")
        ->check(CLI::Range(0.1, 30.0));
    app.add_option("--port", o.port, "inverse3: the port of Haply's service, when not the usual one");
    app.add_option("--socket", o.socket, "bridge: the socket it listens on, when not the usual one");
}

void addHand(CLI::App& run, stylet::trainer::RunOptions& o) {
    run.add_option("--device", o.device,
                   "whose hand: scripted, replay, or a device that \"stylet devices\" lists")
        ->capture_default_str();
    run.add_option("--trace", o.trace, "replay: the hand's CSV file");
    run.add_option("--seconds", o.seconds, "a device: ends after so long (default: with Ctrl-C)")
        ->check(CLI::Range(0.1, 86400.0));
    addDeviceOptions(run, o.device_options);
}

void addRun(CLI::App& app, stylet::trainer::RunOptions& o) {
    CLI::App* run = app.add_subcommand("run", "a scripted attempt: patient, needle, pictures, summary");
    run->add_option("--scenario", o.scenario, "name in assets/scenarios, or a .toml file")
        ->capture_default_str();
    run->add_option("--patient", o.patient, "patient package; default: the reference patient of the seed");
    run->add_option("--seed", o.seed, "seed of patient and hand")
        ->check([](const std::string& text) { return text.starts_with('-') ? text + " is negative" : ""; })
        ->capture_default_str();
    run->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    run->add_option("--rate-hz", o.rate_hz, "ticks a second of the haptics loop")
        ->check(CLI::Range(1000.0, 4000.0))
        ->capture_default_str();
    run->add_option("--out", o.out, "folder for summary, pictures and record")->required();
    run->add_flag("--headless", o.headless, "use the bundled mock runtime unless XR_RUNTIME_JSON names one");
    run->add_flag("--fast", o.fast, "virtual clock: as fast as it goes, the same hash every time");
    run->add_option("--fps", o.fps, "frames a simulated second with --fast (default 0: none)")
        ->check(CLI::Range(0.0, 1000.0));
    run->add_flag("--stats", o.stats, "print what the pictures did not need to draw");
    run->add_flag("--validation", o.validation, "Vulkan validation and synchronisation layers");
    addHand(*run, o);
    run->footer(stylet::trainer::describeWords());
}

void addReplay(CLI::App& app, stylet::trainer::ReplayOptions& o) {
    CLI::App* replay = app.add_subcommand("replay", "compute a record again and compare its hashes");
    replay->add_option("--save-hand", o.save_hand,
                       "also write the recorded hand as CSV, for --device replay");
    replay->add_option("record", o.record, "the record's folder")->required();
    replay->add_option("--out", o.out, "folder for summary and pictures")->required();
    replay->add_option("--patient", o.patient, "patient package, if it has moved");
    replay->add_flag("--fast", o.fast, "as fast as it goes");
}

void addCurves(CLI::App& app, stylet::trainer::CurvesOptions& o) {
    CLI::App* curves = app.add_subcommand("curves", "pictures of what the force table feels like");
    curves->add_option("--table", o.table, "TOML with [[tissue]] and [thresholds]; default: the shipped one");
    curves->add_option("--out", o.out, "folder for the pictures")->required();
}

void addPalpate(CLI::App& app, stylet::trainer::PalpateOptions& o) {
    CLI::App* palpate = app.add_subcommand("palpate", "the right flank under the finger: ribs and gaps");
    palpate->add_option("--out", o.out, "folder for the picture and its numbers")->required();
    palpate->add_option("--patient", o.patient,
                        "patient package; default: the reference patient of the seed");
    palpate->add_option("--seed", o.seed, "seed of a reference patient")->capture_default_str();
    palpate->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    palpate->add_flag("--breathing", o.breathing, "while the patient breathes; default: the breath held");
}

void addFilm(CLI::App& app, stylet::trainer::FilmOptions& o) {
    CLI::App* film =
        app.add_subcommand("film", "a scenario's breath: dome and signal, coronal and stereo film");
    film->add_option("--out", o.out, "folder for table, curve and pictures")->required();
    film->add_option("--scenario", o.scenario, "name in assets/scenarios, or a .toml file")
        ->capture_default_str();
    film->add_option("--patient", o.patient, "patient package; default: the reference patient of the seed");
    film->add_option("--seed", o.seed, "seed of patient and breath")->capture_default_str();
    film->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    film->add_option("--recording", o.recording, "CSV of a marker's track in place of the scenario's rhythm");
    film->add_option("--frames", o.frames, "pictures of the film")
        ->check(CLI::Range(1, 120))
        ->capture_default_str();
    film->add_option("--seconds", o.seconds, "of the film; default: one breath")
        ->check(CLI::Range(0.1, 600.0));
    film->add_flag("!--no-stereo", o.stereo, "coronal slices only");
}

struct DevicesOptions {
    stylet::haptics::DeviceOptions options;
    bool json = false;
    std::filesystem::path calibrate;
};

void addDevices(CLI::App& app, DevicesOptions& o) {
    CLI::App* devices =
        app.add_subcommand("devices", "which devices there are, in which state, with which limits");
    devices->add_flag("--json", o.json, "for programs");
    devices->add_option("--calibrate", o.calibrate,
                        "falcon: measure its newtons with a kitchen scale, into this file");
    addDeviceOptions(*devices, o.options);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app(
        "Stylet: a trainer for percutaneous transhepatic cholangio-drainage.\n"
        "A training simulator, not a medical device.");
    // Optional to the parser, so that a stray word is named before the missing command is.
    app.require_subcommand(0, 1);
    app.callback([&app] {
        if (app.get_subcommands().empty())
            throw CLI::RequiredError("A command: run, replay, curves, palpate, film or devices");
    });
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::trainer::RunOptions run_options;
    stylet::trainer::ReplayOptions replay_options;
    stylet::trainer::CurvesOptions curves_options;
    addRun(app, run_options);
    addReplay(app, replay_options);
    addCurves(app, curves_options);
    stylet::trainer::PalpateOptions palpate_options;
    addPalpate(app, palpate_options);
    stylet::trainer::FilmOptions film_options;
    addFilm(app, film_options);
    DevicesOptions devices_options;
    addDevices(app, devices_options);
    CLI11_PARSE(app, argc, argv);
    try {
        if (app.got_subcommand("run")) return stylet::trainer::run(run_options);
        if (app.got_subcommand("palpate")) return stylet::trainer::palpate(palpate_options);
        if (app.got_subcommand("film")) return stylet::trainer::film(film_options);
        if (app.got_subcommand("curves")) return stylet::trainer::curves(curves_options);
        if (app.got_subcommand("replay")) return stylet::trainer::replay(replay_options);
        if (!devices_options.calibrate.empty()) {
            stylet::trainer::calibrateFalcon(devices_options.options, devices_options.calibrate);
            return 0;
        }
        std::fputs(stylet::trainer::describeDevices(devices_options.options, devices_options.json).c_str(),
                   stdout);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet: %s\n", e.what());
        return 2;
    }
}
