// The command line of `stylet`. A training simulator, not a medical device.
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "app/installation.h"
#include "app/options.h"
#include "app/program_linux.h"
#include "app/records/commands.h"
#include "app/records/disk_linux.h"
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
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/patient_source.h"
#include "app/trainer/stores/platform_linux.h"

namespace stylet::trainer {
namespace {

using Work = std::function<int()>;

// Adds a command with its own options. If the user chooses the command, `work` is set to it.
template <typename Options>
std::pair<CLI::App*, Options&> addCommand(CLI::App& app, Work& work, const char* name, const char* what,
                                          int (*command)(const Options&)) {
    const auto options = std::make_shared<Options>();
    CLI::App* added = app.add_subcommand(name, what);
    added->callback([=, &work] { work = [=] { return command(*options); }; });
    return {added, *options};
}

// Adds the options for files and addresses that some devices need.
void addDeviceOptions(CLI::App& app, haptics::DeviceOptions& o) {
    app.add_option("--device-model", o.model, "woodenhaptics: JSON file with the dimensions of the device.");
    app.add_option("--firmware", o.firmware, "falcon: firmware image to load into the device.");
    app.add_option("--calibration", o.calibration,
                   "falcon: calibration file, written by \"stylet devices --calibrate\".");
    app.add_option("--device-force-n", o.force_peak_n, "inverse3: maximum force [N], from its data sheet.")
        ->check(inRange(0.1, 30.0));
    app.add_option("--port", o.port, "inverse3: port of Haply's service (default: the usual one).");
    app.add_option("--socket", o.socket, "bridge: socket of the bridge program (default: the usual one).");
}

CLI::Option* addDatabase(CLI::App& app, std::string& database) {
    return app
        .add_option(
            "--database", database,
            "PostgreSQL database of the training centre: postgresql://USER@HOST/NAME or \"host=... "
            "dbname=...\" (default: $STYLET_DATABASE, which keeps a password out of the process list).")
        ->envname("STYLET_DATABASE");
}

// Adds an option for a number with a default and inclusive limits.
template <typename Number>
void addNumber(CLI::App& app, const char* name, Number& value, std::pair<Number, Number> limits,
               const char* what) {
    app.add_option(name, value, what)->check(inRange(limits.first, limits.second))->capture_default_str();
}

CLI::Option* addSeed(CLI::App& app, std::uint64_t& seed, const char* what) {
    return app.add_option("--seed", seed, what)
        ->check([](const std::string& text) { return text.starts_with('-') ? text + " is negative" : ""; })
        ->capture_default_str();
}

void addSpacing(CLI::App& app, double& spacing_mm) {
    addNumber(app, "--spacing-mm", spacing_mm, {0.5, 5.0}, "Voxel size of a reference patient [mm].");
}

void addPatient(CLI::App& app, PatientOptions& o, const char* seed = "Seed of a reference patient.") {
    app.add_option("--patient", o.folder, "Patient package (default: the reference patient of the seed).");
    addSeed(app, o.seed, seed);
    addSpacing(app, o.spacing_mm);
}

void addHand(CLI::App& run, RunOptions& o) {
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
        ->check(inRange(0.1, 86400.0));
    addDeviceOptions(run, o.config.device_options);
}

void addView(CLI::App& run, AttemptConfig& config) {
    run.add_flag(
        "--passthrough", config.passthrough,
        "Show the real room behind the patient and the equipment, if the headset supports passthrough.");
    run.add_flag("--foveation", config.foveation,
                 "Foveated rendering: cast fewer rays outside the centre of the view.");
    run.add_flag("--seated", config.seated, "Seated mode: lower the stage to the user's eye height.");
    run.add_option("--budget-ms", config.budget_ms,
                   "Frame-time budget [ms]; the resolution adapts to it (default: on a GPU, the runtime's "
                   "frame period).")
        ->check(inRange(1.0, 1000.0));
}

void addMirrorAndSound(CLI::App& run, RunOptions& o) {
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

// The patient, the task and the instruments.
void addTask(CLI::App& run, RunOptions& o) {
    run.add_option("--scenario", o.config.scenario, "Scenario: a name in assets/scenarios, or a .toml file.")
        ->default_str("demo");
    CLI::Option* needle =
        run.add_option("--needle", o.config.needle_name,
                       "Needle: a name listed by \"stylet instruments\", or a .toml file (default: the "
                       "scenario's, else needle-17g).")
            ->type_name("NAME");
    CLI::Option* instruments =
        run.add_option("--instrument", o.config.instrument_names,
                       "Needle, scalpel, probe, finger, guide wire, dilator or drain: a name listed by "
                       "\"stylet instruments\", or a .toml file. Repeat the option for instruments of other "
                       "kinds (default: the scenario's, else needle-17g, scalpel, probe-convex, finger, "
                       "guide-wire, dilator, drain).")
            ->type_name("NAME")
            ->allow_extra_args(false);
    CLI::Option* seed = addSeed(
        run, o.config.seed, "Seed of the reference patient, of the scripted input and of a drainage's case.");
    CLI::Option* from =
        run.add_option(
               "--from", o.from,
               "Restart an earlier attempt (folder or id) at a bookmark (number or text; default: the last "
               "one). The new attempt is for training only: it enters no statistics.")
            ->type_name("ATTEMPT[@BOOKMARK]")
            ->excludes(needle)
            ->excludes(instruments)
            ->excludes(seed);
    run.add_option("--patient", o.config.patient,
                   "Patient package (default: the reference patient of the seed).");
    run.add_flag("--accept-implausible", o.config.accept_implausible,
                 "Use a patient that `stylet-model check` refused. The record says so. For instructors.");
    run.add_option(
           "--full", o.config.full,
           "Fully segmented package of the same CT. Its force is computed alongside and compared with "
           "the force the user feels.")
        ->type_name("DIR");
    addSpacing(run, o.config.spacing_mm);
    run.add_option(
           "--path", o.config.path,
           "Reference path: the patient's N-th best planned path (default: the best; in a drainage, the best "
           "for the wire), or an attempt folder whose needle track is used instead.")
        ->type_name("N|DIR")
        ->excludes(from);
    addNumber(run, "--rate-hz", o.config.rate_hz, {1000.0, 4000.0}, "Rate of the haptics loop [Hz].");
}

// Where the results are stored.
void addResults(CLI::App& run, RunOptions& o) {
    CLI::Option* out =
        run.add_option("--out", o.config.folder, "Folder for the summary, the pictures and the record.");
    CLI::Option* trainee =
        run.add_option(
               "--trainee", o.config.trainee,
               "Pseudonym of the trainee (letters, digits, . _ -). Store the attempt and its score in the "
               "store instead of --out.")
            ->excludes(out);
    run.add_option("--records", o.records, "Folder of the store (default: $XDG_DATA_HOME/stylet/records).")
        ->needs(trainee);
    addDatabase(run, o.database);
    run.parse_complete_callback([&] {
        if (o.config.folder.empty() && o.config.trainee.empty())
            throw CLI::RequiredError("--out or --trainee");
        if (run.count("--from") > 0 && run.count("--rate-hz") > 0)
            throw CLI::ValidationError(
                "--rate-hz", "--from continues at the rate of the recorded attempt; remove --rate-hz");
    });
}

void addRun(CLI::App& app, Work& work) {
    const auto [run, o] =
        addCommand(app, work, "run",
                   "Run an attempt with scripted input or a device. Writes pictures, a record and a summary.",
                   trainer::run);
    addTask(*run, o);
    addResults(*run, o);
    run->add_flag("--headless", o.config.headless,
                  "Use the bundled mock runtime, unless XR_RUNTIME_JSON names another one.");
    run->add_flag("--fast", o.config.fast,
                  "Run on a virtual clock, as fast as possible. The state hash is reproducible.");
    run->add_option("--fps", o.fps, "With --fast: frames to render per simulated second (default 0: none).")
        ->check(inRange(0.0, 1000.0));
    run->add_option(
           "--look", o.look,
           "How to show the patient: reveal (translucent, with ducts, vessels and ribs), closed (skin), "
           "another name in assets/looks, or a .toml file.")
        ->capture_default_str();
    addView(*run, o.config);
    addNumber(*run, "--patience", o.config.frame_patience_s, {0.1, 600.0},
              "Time to wait for the OpenXR runtime's last frame [s] before the program ends without it.");
    addMirrorAndSound(*run, o);
    run->add_option(
           "--difficulty", o.difficulty,
           "How much help to show: guided (all), practice (no path in the air, no next step) or exam (only "
           "what a real room shows). Default: practice; with --trainee, guided until the trainee has "
           "completed one guided attempt.")
        ->check(CLI::IsMember({"guided", "practice", "exam"}));
    run->add_flag("--stats", o.config.stats, "Print how much of the scene the renderer could skip.");
    run->add_flag("--validation", o.config.validation,
                  "Enable the Vulkan validation and synchronisation layers.");
    addHand(*run, o);
    // A drainage has every command.
    run->footer(describeCommands(true, training::Course::drainage) + describeInstructorCommands());
}

int listInstruments() {
    for (const haptics::Instrument& one : haptics::loadInstruments(assetsFolder() / "instruments"))
        printResult("{}\n", haptics::describe(one));
    return 0;
}

void addInstruments(CLI::App& app, Work& work) {
    CLI::App* list = app.add_subcommand("instruments",
                                        "List the instruments of assets/instruments and their main numbers.");
    list->callback([&work] { work = listInstruments; });
}

void addReplay(CLI::App& app, Work& work) {
    const auto [replay, o] =
        addCommand(app, work, "replay", "Replay a record and compare its state hashes.", trainer::replay);
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
        ->check(inRange(0.0, 86400.0));
    replay
        ->add_option("--ghost", o.ghost,
                     "With --show: an expert's attempt on the same patient, whose needle is shown beside.")
        ->needs(show);
}

void addRecords(CLI::App& app, Work& work) {
    CLI::App* all = app.add_subcommand(
        "records", "List, check, export and delete the attempts stored by \"run --trainee\".");
    all->require_subcommand(1);
    const auto options = std::make_shared<records::RecordsOptions>();
    records::RecordsOptions& o = *options;
    const auto add = [&](const char* name, const char* what, int (*command)(const records::RecordsOptions&)) {
        CLI::App* one = all->add_subcommand(name, what);
        one->add_option("--records", o.store,
                        "Folder of the store (default: $XDG_DATA_HOME/stylet/records).");
        one->callback([=, &work] {
            if (options->store.empty()) options->store = dataFolder() / "records";
            work = [=] { return command(*options); };
        });
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
    add("discard", "Delete an attempt that was aborted or cut short, with a line in the store's log.",
        records::discardAttempt)
        ->add_option("id", o.id, "Id of the attempt.")
        ->required();
    add("log", "Print which attempts were discarded, and when.", records::printLog);
    addDatabase(
        *add("sync", "Send pending attempts to the training centre once (exit 1: some are still pending).",
             records::syncStore),
        o.database)
        ->required();
}

void addCurves(CLI::App& app, Work& work) {
    const auto [curves, o] =
        addCommand(app, work, "curves", "Draw force curves of a tissue table.", trainer::curves);
    curves->add_option("--table", o.table,
                       "TOML file with [[tissue]] and [thresholds] (default: the shipped table).");
    curves->add_option("--out", o.out, "Folder for the pictures.")->required();
}

void addPalpate(CLI::App& app, Work& work) {
    const auto [palpate, o] =
        addCommand(app, work, "palpate",
                   "Draw the force that a finger feels on the right flank: ribs and gaps.", trainer::palpate);
    palpate->add_option("--out", o.out, "Folder for the picture and its values.")->required();
    addPatient(*palpate, o.source);
    palpate->add_flag("--breathing", o.breathing, "Let the patient breathe (default: breath-hold).");
}

void addFilm(CLI::App& app, Work& work) {
    const auto [film, o] = addCommand(
        app, work, "film", "Draw a scenario's breathing: dome and signal curves, coronal and stereo film.",
        trainer::film);
    film->add_option("--out", o.out, "Folder for the table, the curve and the pictures.")->required();
    film->add_option("--scenario", o.scenario, "Scenario: a name in assets/scenarios, or a .toml file.")
        ->capture_default_str();
    addPatient(*film, o.source, "Seed of the reference patient and of its breathing.");
    film->add_option("--recording", o.recording,
                     "CSV file of a marker's motion, used instead of the scenario's breathing.");
    addNumber(*film, "--frames", o.frames, {1, 120}, "Number of film frames.");
    film->add_option("--seconds", o.seconds, "Length of the film [s] (default: one breath).")
        ->check(inRange(0.1, 600.0));
    film->add_flag("!--no-stereo", o.stereo, "Draw coronal slices only.");
}

void addLooks(CLI::App& app, Work& work) {
    const auto [looks, o] = addCommand(
        app, work, "looks", "Render a patient as a headset shows it, for both eyes.", trainer::looks);
    looks->add_option("--out", o.out, "Folder for the pictures.")->required();
    addPatient(*looks, o.source);
    addNumber(*looks, "--pixels", o.pixels, {32, 4096}, "Width and height of an eye's picture, in pixels.");
}

void addImaging(CLI::App& app, Work& work) {
    const auto [imaging, o] =
        addCommand(app, work, "imaging",
                   "Draw ultrasound and X-ray pictures of a patient, with needle and contrast medium.",
                   trainer::imaging);
    imaging->add_option("--out", o.out, "Folder for the pictures.")->required();
    addPatient(*imaging, o.source);
}

void addRegister(CLI::App& app, Work& work) {
    const auto [reg, o] = addCommand(
        app, work, "register",
        "Measure where the haptic device stands in the headset's room, with a wizard in the headset.",
        registerDevice);
    reg->add_option("--device", o.device, "Device listed by \"stylet devices\", or replay.")->required();
    reg->add_option("--trace", o.trace, "With --device replay: CSV file of the recorded input.");
    addNumber(*reg, "--points", o.points, {4, 34}, "Number of points to touch.");
    reg->add_flag("--in-motion", o.in_motion,
                  "Move both tips together through the whole workspace instead of touching points.");
    reg->add_flag("--redo", o.redo, "Register again without first checking an earlier registration.");
    addNumber(*reg, "--touches", o.touches, {1, 8},
              "Number of points to touch when checking an earlier registration.");
    reg->add_option("--hand", o.hand, "Hand that holds the controller: left or right.")
        ->check(CLI::IsMember({"left", "right"}))
        ->capture_default_str();
    reg->add_option("--tip-mm", o.grip_from_tip_mm,
                    "Position x y z of the controller's tip in its grip frame [mm], if known.")
        ->expected(3)
        ->check(inRange(-1000.0, 1000.0));
    reg->add_option("--out", o.out,
                    "File to write the registration to (default: where \"stylet run\" looks for it).");
    reg->add_flag("--validation", o.validation, "Enable the Vulkan validation and synchronisation layers.");
    addDeviceOptions(*reg, o.device_options);
}

struct DevicesOptions {
    haptics::DeviceOptions options;
    bool json = false;
    std::filesystem::path calibrate;
};

int listOrCalibrate(const DevicesOptions& o) {
    if (o.calibrate.empty())
        printResult("{}", describeDevices(o.options, o.json));
    else
        calibrateFalcon(o.options, o.calibrate);
    return 0;
}

void addDevices(CLI::App& app, Work& work) {
    const auto [devices, o] = addCommand(
        app, work, "devices", "List the haptic devices with their state and limits.", listOrCalibrate);
    devices->add_flag("--json", o.json, "Print JSON.");
    devices->add_option(
        "--calibrate", o.calibrate,
        "falcon: calibrate its force with a kitchen scale and write the result to this file.");
    addDeviceOptions(*devices, o.options);
}

void addDoctor(CLI::App& app, Work& work) {
    const auto [doctor, o] = addCommand(
        app, work, "doctor",
        "Check this computer for the trainer: list what is present, what is missing and how to fix it.",
        trainer::doctor);
    doctor->add_flag("--json", o.json, "Print JSON.");
    doctor->add_option("--records", o.records, "Also read every record in this folder.");
    doctor
        ->add_option_function<double>(
            "--patience",
            [&o = o](double seconds) { o.patience = std::chrono::milliseconds(std::llround(1e3 * seconds)); },
            "Time to wait for an answer of a runtime or driver [s] (default 5).")
        ->check(inRange(0.1, 600.0));
    addDeviceOptions(*doctor, o.devices);
}

// Adds a hidden command for `stylet doctor`, which uses it to check a runtime or driver in a child process.
void addProbe(CLI::App& app, Work& work) {
    struct Probed {
        std::string what;
        int patience_ms = 0;
    };
    const auto o = std::make_shared<Probed>();
    CLI::App* added = app.add_subcommand("probe", "")->group("");
    added->add_option("what", o->what)->required();
    added->add_option("patience", o->patience_ms)->required();
    added->callback(
        [=, &work] { work = [=] { return probe(o->what, std::chrono::milliseconds(o->patience_ms)); }; });
}

int runStylet(int argc, char** argv) {
    CLI::App app(
        "Stylet: a trainer for percutaneous transhepatic cholangio-drainage.\n"
        "A training simulator, not a medical device.",
        "stylet");
    // The parser accepts a missing command, so that it can report an unknown word instead.
    app.require_subcommand(0, 1);
    app.callback([&app] {
        if (app.get_subcommands().empty())
            throw CLI::RequiredError(
                "A command: run, replay, records, curves, palpate, film, looks, imaging, register, devices, "
                "instruments or doctor");
    });
    app.set_version_flag("--version", STYLET_VERSION);
    Work work;
    for (const auto add : {addRun, addReplay, addInstruments, addCurves, addRecords, addPalpate, addFilm,
                           addLooks, addImaging, addRegister, addDevices, addDoctor, addProbe})
        add(app, work);
    return runProgram(app, argc, argv, [&] { return work(); });
}

}  // namespace
}  // namespace stylet::trainer

int main(int argc, char** argv) {
    stylet::records::makeNewFilesPrivate();
    return stylet::trainer::runStylet(argc, argv);
}
