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
    app.add_option("--device-model", o.model, "woodenhaptics: JSON file with the dimensions of the device.");
    app.add_option("--firmware", o.firmware, "falcon: firmware image to load into the device.");
    app.add_option("--calibration", o.calibration, "falcon: calibration file, newtons per count.");
    app.add_option("--device-force-n", o.force_peak_n, "inverse3: maximum force [N], from its data sheet.")
        ->check(CLI::Range(0.1, 30.0));
    app.add_option("--port", o.port, "inverse3: port of Haply's service (default: the usual one).");
    app.add_option("--socket", o.socket, "bridge: socket to listen on (default: the usual one).");
}

CLI::Option* addDatabase(CLI::App& app, std::string& database) {
    return app
        .add_option(
            "--database", database,
            "PostgreSQL database of the training centre: postgresql://USER@HOST/NAME or \"host=... "
            "dbname=...\" (default: $STYLET_DATABASE, which keeps a password out of the process list).")
        ->envname("STYLET_DATABASE");
}

void addHand(CLI::App& run, stylet::trainer::RunOptions& o) {
    run.add_option("--device", o.config.device,
                   "Input: scripted, replay, controllers, mouse (in the mirror window, with its keys), or a "
                   "device listed by \"stylet devices\".")
        ->capture_default_str();
    run.add_option("--hand", o.config.hand, "With --device controllers: the hand that holds the tool.")
        ->check(CLI::IsMember({"left", "right"}))
        ->capture_default_str();
    run.add_option("--trace", o.config.trace, "With --device replay: CSV file of the recorded input.");
    run.add_option("--seconds", o.config.seconds,
                   "With a device: end the attempt after this time [s] (default: on Ctrl-C).")
        ->check(CLI::Range(0.1, 86400.0));
    addDeviceOptions(run, o.config.device_options);
}

void addView(CLI::App& run, stylet::trainer::AttemptConfig& config) {
    run.add_flag(
        "--passthrough", config.passthrough,
        "Show the real room behind the patient and the equipment, if the headset supports passthrough.");
    run.add_flag("--foveation", config.foveation,
                 "Foveated rendering: cast fewer rays outside the centre of the view.");
    run.add_flag("--seated", config.seated, "Seated mode: lower the stage to the user's eye height.");
    run.add_option("--budget-ms", config.budget_ms,
                   "Frame-time budget [ms]; the resolution adapts to it (default: on a GPU, the runtime's "
                   "frame period).")
        ->check(CLI::Range(1.0, 1000.0));
}

void addMirrorAndSound(CLI::App& run, stylet::trainer::RunOptions& o) {
    CLI::Option* mirror = run.add_flag_callback(
        "--mirror", [&o] { o.mirror = true; },
        "Open a mirror window (default: when a display is available, without --headless and --fast).");
    run.add_flag_callback(
           "--no-mirror", [&o] { o.mirror = false; }, "Do not open a window.")
        ->excludes(mirror);
    CLI::Option* sound = run.add_flag_callback(
        "--sound", [&o] { o.sound = true; },
        "Play sound through the default audio device (default: on, without --headless).");
    run.add_flag_callback("--mute", [&o] { o.sound = false; }, "Do not play sound.")->excludes(sound);
}

void addRun(CLI::App& app, stylet::trainer::RunOptions& o) {
    CLI::App* run = app.add_subcommand(
        "run", "Run an attempt with scripted input or a device. Writes pictures, a record and a summary.");
    run->add_option("--scenario", o.config.scenario, "Scenario: a name in assets/scenarios, or a .toml file.")
        ->default_str("demo");
    run->add_option(
           "--from", o.from,
           "Restart an earlier attempt (folder or id) at a bookmark (number or text; default: the last "
           "one).")
        ->type_name("ATTEMPT[@BOOKMARK]");
    run->add_option("--patient", o.config.patient,
                    "Patient package (default: the reference patient of the seed).");
    run->add_option(
           "--full", o.config.full,
           "Fully segmented package of the same CT. Its force is computed alongside and compared with "
           "the force the user feels.")
        ->type_name("DIR");
    run->add_option("--seed", o.config.seed, "Seed of the reference patient and of the scripted input.")
        ->check([](const std::string& text) { return text.starts_with('-') ? text + " is negative" : ""; })
        ->capture_default_str();
    run->add_option("--spacing-mm", o.config.spacing_mm, "Voxel size of a reference patient [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    run->add_option("--path", o.config.path,
                    "Reference path: the patient's N-th best planned path (default 1), or an attempt folder "
                    "whose needle track is used instead.")
        ->type_name("N|DIR");
    run->add_option("--rate-hz", o.config.rate_hz, "Rate of the haptics loop [Hz].")
        ->check(CLI::Range(1000.0, 4000.0))
        ->capture_default_str();
    CLI::Option* out =
        run->add_option("--out", o.config.folder, "Folder for the summary, the pictures and the record.");
    CLI::Option* trainee =
        run->add_option(
               "--trainee", o.config.trainee,
               "Pseudonym of the trainee (letters, digits, . _ -). Store the attempt and its score in the "
               "store instead of --out.")
            ->excludes(out);
    run->add_option("--records", o.records, "Folder of the store (default: $XDG_DATA_HOME/stylet/records).")
        ->needs(trainee);
    addDatabase(*run, o.database);
    run->parse_complete_callback([&o] {
        if (o.config.folder.empty() && o.config.trainee.empty())
            throw CLI::RequiredError("--out or --trainee");
    });
    run->add_flag("--headless", o.config.headless,
                  "Use the bundled mock runtime, unless XR_RUNTIME_JSON names another one.");
    run->add_flag("--fast", o.config.fast,
                  "Run on a virtual clock, as fast as possible. The state hash is reproducible.");
    run->add_option("--fps", o.fps, "With --fast: frames to render per simulated second (default 0: none).")
        ->check(CLI::Range(0.0, 1000.0));
    run->add_option(
           "--look", o.look,
           "How to show the patient: reveal (translucent, with ducts, vessels and ribs) or closed (skin).")
        ->check(CLI::IsMember({"reveal", "closed"}))
        ->capture_default_str();
    addView(*run, o.config);
    run->add_option(
           "--patience", o.config.frame_patience_s,
           "Time to wait for the OpenXR runtime's last frame [s] before the program ends without it.")
        ->check(CLI::Range(0.1, 600.0))
        ->capture_default_str();
    addMirrorAndSound(*run, o);
    run->add_option(
           "--difficulty", o.difficulty,
           "How much help to show: guided (all), practice (no path in the air, no next step) or exam (only "
           "what a real room shows). Default: guided in a trainee's first run, else practice.")
        ->check(CLI::IsMember({"guided", "practice", "exam"}));
    run->add_flag("--stats", o.config.stats, "Print how much of the scene the renderer could skip.");
    run->add_flag("--validation", o.config.validation,
                  "Enable the Vulkan validation and synchronisation layers.");
    addHand(*run, o);
    run->footer(stylet::trainer::describeWords() + stylet::trainer::describeInstructorWords());
}

void addReplay(CLI::App& app, stylet::trainer::ReplayOptions& o) {
    CLI::App* replay = app.add_subcommand("replay", "Replay a record and compare its state hashes.");
    replay->add_option("--save-hand", o.save_hand,
                       "Also write the recorded input as CSV, for --device replay.");
    replay->add_option("record", o.record, "Folder of the record.")->required();
    replay->add_option("--out", o.out, "Folder for the summary and the pictures.")->required();
    replay->add_option("--patient", o.patient, "Patient package, if it has moved.");
    replay->add_option("--full", o.full, "Fully segmented package of the same CT, as in \"stylet run\".");
    replay->add_flag("--fast", o.fast, "Replay as fast as possible.");
    CLI::Option* show = replay->add_flag("--show", o.show,
                                         "Show the attempt in a headset, or else in a window: scrub it, play "
                                         "it slowly or fast, view it from any side.");
    replay->add_flag("--window", o.window, "With --show: use a window even if a headset is connected.")
        ->needs(show);
    replay->add_option("--at", o.at_s, "With --show: start paused at this time [s].")
        ->needs(show)
        ->check(CLI::Range(0.0, 86400.0));
    replay
        ->add_option("--ghost", o.ghost,
                     "With --show: an expert's attempt on the same patient, whose needle is shown beside.")
        ->needs(show);
}

using RecordsCommand = int (*)(const stylet::records::RecordsOptions&);

// `stylet records ...`; sets `chosen` to the selected command.
void addRecords(CLI::App& app, stylet::records::RecordsOptions& o, RecordsCommand& chosen) {
    namespace records = stylet::records;
    CLI::App* all = app.add_subcommand(
        "records", "List, check, export and delete the attempts stored by \"run --trainee\".");
    all->require_subcommand(1);
    const auto add = [&](const char* name, const char* what, RecordsCommand command) {
        CLI::App* one = all->add_subcommand(name, what);
        one->add_option("--records", o.store,
                        "Folder of the store (default: $XDG_DATA_HOME/stylet/records).");
        one->callback([&chosen, command] { chosen = command; });
        return one;
    };
    add("list", "Print one line for each attempt, oldest first.", records::listAttempts)
        ->add_option("--trainee", o.trainee, "Only this trainee.");
    add("show", "Print the index entry of an attempt and the location of its files.", records::showAttempt)
        ->add_option("id", o.id, "Id of the attempt.")
        ->required();
    add("recover", "Repair the store after a crash and verify every stored byte (exit 1: damage found).",
        records::recoverStore);
    CLI::App* taken =
        add("export", "Export tables, files and their checksums into a folder.", records::exportStore);
    taken->add_option("folder", o.out, "New or empty folder.")->required();
    taken->add_option("--trainee", o.trainee, "Only this trainee.");
    add("delete", "Delete a trainee's attempts here, and at the training centre on the next sync.",
        records::deleteTrainee)
        ->add_option("--trainee", o.trainee, "Pseudonym of the trainee.")
        ->required();
    addDatabase(
        *add("sync", "Send pending attempts to the training centre once (exit 1: some are still pending).",
             records::syncStore),
        o.database)
        ->required();
}

void addCurves(CLI::App& app, stylet::trainer::CurvesOptions& o) {
    CLI::App* curves = app.add_subcommand("curves", "Draw force curves of a tissue table.");
    curves->add_option("--table", o.table,
                       "TOML file with [[tissue]] and [thresholds] (default: the shipped table).");
    curves->add_option("--out", o.out, "Folder for the pictures.")->required();
}

void addPalpate(CLI::App& app, stylet::trainer::PalpateOptions& o) {
    CLI::App* palpate = app.add_subcommand(
        "palpate", "Draw the force that a finger feels on the right flank: ribs and gaps.");
    palpate->add_option("--out", o.out, "Folder for the picture and its values.")->required();
    palpate->add_option("--patient", o.patient,
                        "Patient package (default: the reference patient of the seed).");
    palpate->add_option("--seed", o.seed, "Seed of a reference patient.")->capture_default_str();
    palpate->add_option("--spacing-mm", o.spacing_mm, "Voxel size of a reference patient [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    palpate->add_flag("--breathing", o.breathing, "Let the patient breathe (default: breath-hold).");
}

void addFilm(CLI::App& app, stylet::trainer::FilmOptions& o) {
    CLI::App* film = app.add_subcommand(
        "film", "Draw a scenario's breathing: dome and signal curves, coronal and stereo film.");
    film->add_option("--out", o.out, "Folder for the table, the curve and the pictures.")->required();
    film->add_option("--scenario", o.scenario, "Scenario: a name in assets/scenarios, or a .toml file.")
        ->capture_default_str();
    film->add_option("--patient", o.patient, "Patient package (default: the reference patient of the seed).");
    film->add_option("--seed", o.seed, "Seed of the reference patient and of its breathing.")
        ->capture_default_str();
    film->add_option("--spacing-mm", o.spacing_mm, "Voxel size of a reference patient [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    film->add_option("--recording", o.recording,
                     "CSV file of a marker's motion, used instead of the scenario's breathing.");
    film->add_option("--frames", o.frames, "Number of film frames.")
        ->check(CLI::Range(1, 120))
        ->capture_default_str();
    film->add_option("--seconds", o.seconds, "Length of the film [s] (default: one breath).")
        ->check(CLI::Range(0.1, 600.0));
    film->add_flag("!--no-stereo", o.stereo, "Draw coronal slices only.");
}

void addLooks(CLI::App& app, stylet::trainer::LooksOptions& o) {
    CLI::App* looks = app.add_subcommand("looks", "Render a patient as a headset shows it, for both eyes.");
    looks->add_option("--out", o.out, "Folder for the pictures.")->required();
    looks->add_option("--patient", o.patient,
                      "Patient package (default: the reference patient of the seed).");
    looks->add_option("--seed", o.seed, "Seed of a reference patient.")->capture_default_str();
    looks->add_option("--spacing-mm", o.spacing_mm, "Voxel size of a reference patient [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
    looks->add_option("--pixels", o.pixels, "Width and height of an eye's picture, in pixels.")
        ->check(CLI::Range(32, 4096))
        ->capture_default_str();
}

void addImaging(CLI::App& app, stylet::trainer::ImagingOptions& o) {
    CLI::App* imaging = app.add_subcommand(
        "imaging", "Draw ultrasound and X-ray pictures of a patient, with needle and contrast medium.");
    imaging->add_option("--out", o.out, "Folder for the pictures.")->required();
    imaging->add_option("--patient", o.patient,
                        "Patient package (default: the reference patient of the seed).");
    imaging->add_option("--seed", o.seed, "Seed of a reference patient.")->capture_default_str();
    imaging->add_option("--spacing-mm", o.spacing_mm, "Voxel size of a reference patient [mm].")
        ->check(CLI::Range(0.5, 5.0))
        ->capture_default_str();
}

void addRegister(CLI::App& app, stylet::trainer::RegisterOptions& o) {
    CLI::App* reg = app.add_subcommand(
        "register",
        "Measure where the haptic device stands in the headset's room, with a wizard in the headset.");
    reg->add_option("--device", o.device, "Device listed by \"stylet devices\", or replay.")->required();
    reg->add_option("--trace", o.trace, "With --device replay: CSV file of the recorded input.");
    reg->add_option("--points", o.points, "Number of points to touch.")
        ->check(CLI::Range(4, 34))
        ->capture_default_str();
    reg->add_flag("--in-motion", o.in_motion,
                  "Move both tips together through the whole workspace instead of touching points.");
    reg->add_flag("--redo", o.redo, "Register again without first checking an earlier registration.");
    reg->add_option("--touches", o.touches,
                    "Number of points to touch when checking an earlier registration.")
        ->check(CLI::Range(1, 8))
        ->capture_default_str();
    reg->add_option("--hand", o.hand, "Hand that holds the controller: left or right.")
        ->check(CLI::IsMember({"left", "right"}))
        ->capture_default_str();
    reg->add_option("--tip-mm", o.grip_from_tip_mm,
                    "Position x y z of the controller's tip in its grip frame [mm], if known.")
        ->expected(3);
    reg->add_option("--out", o.out,
                    "File to write the registration to (default: where \"stylet run\" looks for it).");
    reg->add_flag("--validation", o.validation, "Enable the Vulkan validation and synchronisation layers.");
    addDeviceOptions(*reg, o.device_options);
}

struct DevicesOptions {
    stylet::haptics::DeviceOptions options;
    bool json = false;
    std::filesystem::path calibrate;
};

void addDevices(CLI::App& app, DevicesOptions& o) {
    CLI::App* devices = app.add_subcommand("devices", "List the haptic devices with their state and limits.");
    devices->add_flag("--json", o.json, "Print JSON.");
    devices->add_option(
        "--calibrate", o.calibrate,
        "falcon: calibrate its force with a kitchen scale and write the result to this file.");
    addDeviceOptions(*devices, o.options);
}

void addDoctor(CLI::App& app, stylet::trainer::DoctorOptions& o) {
    CLI::App* doctor = app.add_subcommand(
        "doctor",
        "Check this computer for the trainer: list what is present, what is missing and how to fix it.");
    doctor->add_flag("--json", o.json, "Print JSON.");
    doctor->add_option("--records", o.records, "Also read every record in this folder.");
    doctor
        ->add_option_function<double>(
            "--patience",
            [&o](double seconds) { o.patience = std::chrono::milliseconds(std::llround(1e3 * seconds)); },
            "Time to wait for an answer of a runtime or driver [s] (default 5).")
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
