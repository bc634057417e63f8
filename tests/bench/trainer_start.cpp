// Benchmark of the time from the program's start to its first picture, as a user experiences it. It runs
// whole processes one after the other on the reference patient at 1 mm. The window is on an Xvfb display
// and the headset is simulated by the mock runtime. Both have their usual size.
#include <array>
#include <cstdlib>
#include <stdexcept>

#include <fmt/core.h>

#include "app/installation.h"
#include "tests/app/trainer/command.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"
#include "tests/support/x_display.h"

namespace stylet::bench {
namespace {

namespace fs = std::filesystem;

// Cache content from earlier starts.
enum CacheState { nothing, patientOnly, all };

constexpr std::array kParts{"asked_s", "patient_s", "hand_s", "pictures_s", "pipelines_s", "frame_s"};

struct Measured {
    std::vector<double> whole_ms, made;
    std::array<std::vector<double>, std::size(kParts)> parts_ms;
};

void measure(test::Command& command, const std::string& arguments, Measured& measured) {
    const test::Outcome outcome = command.run(arguments + " --seconds 0.5");
    if (outcome.status != 0 || !outcome.summary.at("first_picture_s").is_number())
        throw std::runtime_error("no first picture: " + outcome.err);
    const nlohmann::json& start = outcome.summary.at("start");
    measured.whole_ms.push_back(1e3 * outcome.summary.at("first_picture_s").get<double>());
    double made = 0.0;
    for (const char* what : {"patients_made", "marks_made", "plans_made", "touch_maps_made"})
        made += start.at(what).get<double>();
    measured.made.push_back(made);
    for (std::size_t part = 0; part < std::size(kParts); ++part)
        measured.parts_ms[part].push_back(1e3 * start.at(kParts[part]).get<double>());
}

// Deletes the whole cache except the patients. This is the state after an update of the program and of the
// graphics driver.
void deleteAllButThePatient(const fs::path& cache) {
    for (const auto& entry : fs::directory_iterator(cache))
        if (entry.path().filename() != "stylet") fs::remove_all(entry.path());
    for (const auto& entry : fs::directory_iterator(cache / "stylet"))
        if (entry.path().filename() != "patients") fs::remove_all(entry.path());
}

void runWith(const char* name, const std::string& arguments, std::vector<Row>& rows) {
    setenv("STYLET_BIN", programFolder().c_str(), 1);
    test::Command command;
    const int starts = isLongRun() ? 15 : 5;
    for (const CacheState cached : {nothing, patientOnly, all}) {
        Measured measured;
        for (int i = 0; i < (cached == nothing ? 1 : starts); ++i) {
            if (cached == patientOnly) deleteAllButThePatient(command / "cache");
            measure(command, arguments, measured);
        }
        const auto part = [&](std::size_t i) { return median(measured.parts_ms[i]); };
        const std::string note = fmt::format(
            "options {:.0f} ms, package and path {:.0f}, hand and touch map {:.0f}, device, scene and window "
            "{:.0f}, first frame {:.0f}; pipelines {:.0f} of it; {} start{}",
            part(0), part(1), part(2), part(3), part(5), part(4), measured.whole_ms.size(),
            measured.whole_ms.size() == 1 ? "" : "s");
        rows.push_back({name, "kept: none, patient, all", double(cached), median(measured.whole_ms),
                        median(measured.made), "made anew", "0 where all is kept", note});
    }
}

void runHeadset(std::vector<Row>& rows) {
    for (const char* variable : {"XR_RUNTIME_JSON", "XRMOCK_SCENARIO"})  // set by another benchmark
        unsetenv(variable);
    runWith("trainer.start.headset", "run --headless --device controllers", rows);
}
const Registration headset("trainer.start.headset", runHeadset);

#ifdef STYLET_TEST_WINDOW
void runDesktop(std::vector<Row>& rows) {
    const test::XDisplay display(1500, 950);
    runWith("trainer.start.desktop", "run --device mouse", rows);
}
const Registration desktop("trainer.start.desktop", runDesktop);
#endif

}  // namespace
}  // namespace stylet::bench
