// The command line of `stylet`. A training simulator, not a medical device.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <exception>

#include "app/program_linux.h"
#include "app/records/commands.h"
#include "app/trainer/attempt/commands.h"
#include "app/trainer/figures/curves.h"
#include "app/trainer/figures/film.h"
#include "app/trainer/figures/imaging.h"
#include "app/trainer/figures/looks.h"
#include "app/trainer/figures/palpate.h"
#include "app/trainer/program/replay.h"
#include "app/trainer/program/run.h"
#include "app/trainer/session/instructor.h"
#include "app/trainer/setup/calibrate.h"
#include "app/trainer/setup/devices.h"
#include "app/trainer/setup/doctor.h"
#include "app/trainer/setup/register.h"
#include "app/trainer/stores/platform_linux.h"

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

CLI::Option* addDatabase(CLI::App& app, std::string& database) {
    return app
        .add_option(
            "--database", database,
            "the training centre's PostgreSQL, postgresql://USER@HOST/NAME or \"host=... dbname=...\" "
            "(default: $STYLET_DATABASE, which keeps a password from the process list)")
        ->envname("STYLET_DATABASE");
}

void addHand(CLI::App& run, stylet::trainer::RunOptions& o) {
    run.add_option("--device", o.device,
                   "whose hand: scripted, replay, controllers, mouse (in the window, with its keys), or a "
                   "device that "
                   "\"stylet devices\" lists")
        ->capture_default_str();
    run.add_option("--hand", o.hand, "with --device controllers: the hand that has the tool")
        ->check(CLI::IsMember({"left", "right"}))
        ->capture_default_str();
    run.add_option("--trace", o.trace, "replay: the hand's CSV file");
    run.add_option("--seconds", o.seconds, "a device: ends after so long (default: with Ctrl-C)")
        ->check(CLI::Range(0.1, 86400.0));
    addDeviceOptions(run, o.device_options);
}

void addRun(CLI::App& app, stylet::trainer::RunOptions& o) {
    CLI::App* run = app.add_subcommand(
        "run", "an attempt: a scripted hand's, or yours on a device; pictures, record, summary");
    run->add_option("--scenario", o.scenario, "name in assets/scenarios, or a .toml file")
        ->default_str("demo");
    run->add_option("--from", o.from,
                    "ATTEMPT[@BOOKMARK]: again from there (its folder or its id in the store; the bookmark's "
                    "number or text, default the last)");
    run->add_option("--patient", o.patient, "patient package; default: the reference patient of the seed");
    run->add_option("--full", o.full,
                    "the same CT fully segmented, as a package: the force over it is compared with what is "
                    "felt, of a patient who is only partially segmented");
    run->add_option("--seed", o.seed, "seed of patient and hand")
        ->check([](const std::string& text) { return text.starts_with('-') ? text + " is negative" : ""; })
        ->capture_default_str();
    run->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    run->add_option("--path", o.path,
                    "the reference path: N, the patient's N-th best (default: his best), or the folder of an "
                    "expert's attempt on him, the way of its needle");
    run->add_option("--rate-hz", o.rate_hz, "ticks a second of the haptics loop")
        ->check(CLI::Range(1000.0, 4000.0))
        ->capture_default_str();
    CLI::Option* out = run->add_option("--out", o.out, "folder for summary, pictures and record");
    CLI::Option* trainee =
        run->add_option(
               "--trainee", o.trainee,
               "a pseudonym (letters, digits, . _ -): the attempt is kept in the store, with its score, "
               "instead of --out")
            ->excludes(out);
    run->add_option("--records", o.records, "the store's folder (default: $XDG_DATA_HOME/stylet/records)")
        ->needs(trainee);
    addDatabase(*run, o.database);
    run->parse_complete_callback([&o] {
        if (o.out.empty() && o.trainee.empty()) throw CLI::RequiredError("--out or --trainee");
    });
    run->add_flag("--headless", o.headless, "use the bundled mock runtime unless XR_RUNTIME_JSON names one");
    run->add_flag("--fast", o.fast, "virtual clock: as fast as it goes, the same hash every time");
    run->add_option("--fps", o.fps, "frames a simulated second with --fast (default 0: none)")
        ->check(CLI::Range(0.0, 1000.0));
    run->add_option("--look", o.look, "how the patient is shown: reveal or closed")
        ->check(CLI::IsMember({"reveal", "closed"}))
        ->capture_default_str();
    run->add_flag("--passthrough", o.passthrough,
                  "the real room behind patient and machines, where the headset shows it");
    run->add_flag("--foveation", o.foveation, "fewer rays beside the middle of the view");
    run->add_flag("--seated", o.seated, "the room comes down to the eyes of who sits");
    run->add_option("--budget-ms", o.budget_ms,
                    "of a frame: the resolution keeps to it (default: on a GPU the runtime's pace)")
        ->check(CLI::Range(1.0, 1000.0));
    run->add_option("--patience", o.frame_patience_s,
                    "Seconds that the OpenXR runtime gets for its last frame before the program ends "
                    "without it.")
        ->check(CLI::Range(0.1, 600.0))
        ->capture_default_str();
    CLI::Option* mirror = run->add_flag_callback(
        "--mirror", [&o] { o.mirror = true; },
        "a window for who has no headset on, or instead of one (default: where there is a display, without "
        "--headless and --fast)");
    run->add_flag_callback("--no-mirror", [&o] { o.mirror = false; }, "no window")->excludes(mirror);
    CLI::Option* sound = run->add_flag_callback(
        "--sound", [&o] { o.sound = true; }, "through the default device (default: without --headless)");
    run->add_flag_callback("--mute", [&o] { o.sound = false; }, "no sound")->excludes(sound);
    run->add_option(
           "--difficulty", o.difficulty,
           "how much is shown: guided (all), practice (no path in the air, no next step), exam (only "
           "what a real room has); default: guided in a trainee's first run, else practice")
        ->check(CLI::IsMember({"guided", "practice", "exam"}));
    run->add_flag("--stats", o.stats, "print what the pictures did not need to draw");
    run->add_flag("--validation", o.validation, "Vulkan validation and synchronisation layers");
    addHand(*run, o);
    run->footer(stylet::trainer::describeWords() + stylet::trainer::describeInstructorWords());
}

void addReplay(CLI::App& app, stylet::trainer::ReplayOptions& o) {
    CLI::App* replay = app.add_subcommand("replay", "compute a record again and compare its hashes");
    replay->add_option("--save-hand", o.save_hand,
                       "also write the recorded hand as CSV, for --device replay");
    replay->add_option("record", o.record, "the record's folder")->required();
    replay->add_option("--out", o.out, "folder for summary and pictures")->required();
    replay->add_option("--patient", o.patient, "patient package, if it has moved");
    replay->add_option("--full", o.full, "the same CT fully segmented, as with run");
    replay->add_flag("--fast", o.fast, "as fast as it goes");
    CLI::Option* show = replay->add_flag(
        "--show", o.show, "in a headset, else in a window: scrubbed, slow or fast, from any side");
    replay->add_flag("--window", o.window, "with --show: in a window, though there is a headset")
        ->needs(show);
    replay->add_option("--at", o.at_s, "with --show: it stands there, in seconds, until it is played")
        ->needs(show)
        ->check(CLI::Range(0.0, 86400.0));
    replay
        ->add_option("--ghost", o.ghost,
                     "with --show: an expert's attempt on the same patient, its needle beside")
        ->needs(show);
}

using RecordsCommand = int (*)(const stylet::records::RecordsOptions&);

// `stylet records ...`; sets `chosen` to the selected command.
void addRecords(CLI::App& app, stylet::records::RecordsOptions& o, RecordsCommand& chosen) {
    namespace records = stylet::records;
    CLI::App* all = app.add_subcommand("records", "the attempts that \"run --trainee\" has kept");
    all->require_subcommand(1);
    const auto add = [&](const char* name, const char* what, RecordsCommand command) {
        CLI::App* one = all->add_subcommand(name, what);
        one->add_option("--records", o.store, "the store's folder (default: $XDG_DATA_HOME/stylet/records)");
        one->callback([&chosen, command] { chosen = command; });
        return one;
    };
    add("list", "a line for each attempt, oldest first", records::listAttempts)
        ->add_option("--trainee", o.trainee, "only his");
    add("show", "all that the index says of an attempt, and where its files are", records::showAttempt)
        ->add_option("id", o.id, "the attempt")
        ->required();
    add("recover", "what a crash has cut short, and whether every byte is as it was stored (exit 1: not)",
        records::recoverStore);
    CLI::App* taken = add("export", "tables, files and their checksums, into a folder", records::exportStore);
    taken->add_option("folder", o.out, "made, or empty")->required();
    taken->add_option("--trainee", o.trainee, "only his");
    add("delete", "a trainee's attempts, here and with the next sync at the training centre",
        records::deleteTrainee)
        ->add_option("--trainee", o.trainee, "whose")
        ->required();
    addDatabase(*add("sync", "what waits, to the training centre, once (exit 1: something still waits)",
                     records::syncStore),
                o.database)
        ->required();
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

void addLooks(CLI::App& app, stylet::trainer::LooksOptions& o) {
    CLI::App* looks = app.add_subcommand("looks", "what a headset shows of a patient, both eyes");
    looks->add_option("--out", o.out, "folder for the pictures")->required();
    looks->add_option("--patient", o.patient, "patient package; default: the reference patient of the seed");
    looks->add_option("--seed", o.seed, "seed of a reference patient")->capture_default_str();
    looks->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    looks->add_option("--pixels", o.pixels, "of an eye's picture, along either side")
        ->check(CLI::Range(32, 4096))
        ->capture_default_str();
}

void addImaging(CLI::App& app, stylet::trainer::ImagingOptions& o) {
    CLI::App* imaging = app.add_subcommand(
        "imaging", "what ultrasound and X-ray show of a patient, with needle and contrast");
    imaging->add_option("--out", o.out, "folder for the pictures")->required();
    imaging->add_option("--patient", o.patient,
                        "patient package; default: the reference patient of the seed");
    imaging->add_option("--seed", o.seed, "seed of a reference patient")->capture_default_str();
    imaging->add_option("--spacing-mm", o.spacing_mm, "voxel size of a reference patient")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
}

void addRegister(CLI::App& app, stylet::trainer::RegisterOptions& o) {
    CLI::App* reg = app.add_subcommand(
        "register", "where the haptic device stands in the headset's room: a wizard in the headset");
    reg->add_option("--device", o.device, "one that \"stylet devices\" lists, or replay")->required();
    reg->add_option("--trace", o.trace, "replay: the hand's CSV file");
    reg->add_option("--points", o.points, "places to touch")->check(CLI::Range(4, 34))->capture_default_str();
    reg->add_flag("--in-motion", o.in_motion, "tip on tip through the whole space, instead of points");
    reg->add_flag("--redo", o.redo, "without asking first whether an earlier one still holds");
    reg->add_option("--touches", o.touches, "places touched again when asking that")
        ->check(CLI::Range(1, 8))
        ->capture_default_str();
    reg->add_option("--hand", o.hand, "that holds the controller: left or right")
        ->check(CLI::IsMember({"left", "right"}))
        ->capture_default_str();
    reg->add_option("--tip-mm", o.grip_from_tip_mm,
                    "x y z of the controller's tip in its grip frame, where it is known")
        ->expected(3);
    reg->add_option("--out", o.out, "file to keep it in (default: where \"stylet run\" looks for it)");
    reg->add_flag("--validation", o.validation, "Vulkan validation and synchronisation layers");
    addDeviceOptions(*reg, o.device_options);
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

void addDoctor(CLI::App& app, stylet::trainer::DoctorOptions& o) {
    CLI::App* doctor = app.add_subcommand(
        "doctor", "what this machine has for the trainer, what stands in the way, and what to do about it");
    doctor->add_flag("--json", o.json, "for programs");
    doctor->add_option("--records", o.records, "also read every record in this folder");
    doctor
        ->add_option_function<double>(
            "--patience",
            [&o](double seconds) { o.patience = std::chrono::milliseconds(std::llround(1e3 * seconds)); },
            "seconds that a runtime and a driver get to answer (default 5)")
        ->check(CLI::Range(0.1, 600.0));
    addDeviceOptions(*doctor, o.devices);
}

}  // namespace

static int program(int argc, char** argv) {
    CLI::App app(
        "Stylet: a trainer for percutaneous transhepatic cholangio-drainage.\n"
        "A training simulator, not a medical device.");
    // Optional for the parser, so that an unknown word is reported rather than a missing command.
    app.require_subcommand(0, 1);
    app.callback([&app] {
        if (app.get_subcommands().empty())
            throw CLI::RequiredError(
                "A command: run, replay, records, curves, palpate, film, looks, imaging, register, devices "
                "or doctor");
    });
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::trainer::RunOptions run_options;
    stylet::trainer::ReplayOptions replay_options;
    stylet::trainer::CurvesOptions curves_options;
    addRun(app, run_options);
    addReplay(app, replay_options);
    addCurves(app, curves_options);
    stylet::records::RecordsOptions records_options;
    RecordsCommand records_command = nullptr;
    addRecords(app, records_options, records_command);
    stylet::trainer::PalpateOptions palpate_options;
    addPalpate(app, palpate_options);
    stylet::trainer::FilmOptions film_options;
    addFilm(app, film_options);
    stylet::trainer::LooksOptions looks_options;
    addLooks(app, looks_options);
    stylet::trainer::ImagingOptions imaging_options;
    addImaging(app, imaging_options);
    stylet::trainer::RegisterOptions register_options;
    addRegister(app, register_options);
    DevicesOptions devices_options;
    addDevices(app, devices_options);
    stylet::trainer::DoctorOptions doctor_options;
    addDoctor(app, doctor_options);
    std::string probed;  // only used by `stylet doctor`
    int probe_ms = 0;
    CLI::App* probe = app.add_subcommand("probe", "")->group("");
    probe->add_option("what", probed)->required();
    probe->add_option("patience", probe_ms)->required();
    CLI11_PARSE(app, argc, argv);
    try {
        if (app.got_subcommand("run")) return stylet::trainer::run(run_options);
        if (records_command) {
            if (records_options.store.empty())
                records_options.store = stylet::trainer::dataFolder() / "records";
            return records_command(records_options);
        }
        if (app.got_subcommand("palpate")) return stylet::trainer::palpate(palpate_options);
        if (app.got_subcommand("film")) return stylet::trainer::film(film_options);
        if (app.got_subcommand("imaging")) return stylet::trainer::imaging(imaging_options);
        if (app.got_subcommand("looks")) return stylet::trainer::looks(looks_options);
        if (app.got_subcommand("curves")) return stylet::trainer::curves(curves_options);
        if (app.got_subcommand("doctor")) return stylet::trainer::doctor(doctor_options);
        if (app.got_subcommand("probe"))
            return stylet::trainer::probe(probed, std::chrono::milliseconds(probe_ms));
        if (app.got_subcommand("register")) return stylet::trainer::registerDevice(register_options);
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

int main(int argc, char** argv) {
    return stylet::runProgram("stylet", program, argc, argv);
}
