#include "app/trainer/setup/doctor.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/installation.h"
#include "app/records/record.h"
#include "app/trainer/setup/doctor_linux.h"
#include "app/trainer/setup/probe.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/stores/registration_store.h"
#include "base/child_process_linux.h"
#include "base/text.h"

namespace stylet::trainer {

using json = nlohmann::ordered_json;

namespace {

constexpr std::uintmax_t kLittleSpace = std::uintmax_t(2) << 30;  // space for a 1 mm patient and some records
constexpr std::size_t kMaxFiles = 10000;
constexpr std::array<std::string_view, 3> kStates{"ok", "warning", "problem"};

json findingJson(const Finding& f) {
    return {{"what", f.what}, {"state", enumName(kStates, f.state)}, {"found", f.found}, {"todo", f.todo}};
}

// Returns a text field. Returns an empty string if it is missing or has another type: a driver may print its
// own lines, even JSON.
std::string textIn(const json& line, const char* name) {
    const auto found = line.find(name);
    return found != line.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Finding parseFinding(const json& line) {
    return {textIn(line, "what"),
            findEnum<FindingState>(kStates, textIn(line, "state")).value_or(FindingState::problem),
            textIn(line, "found"), textIn(line, "todo")};
}

// Returns the lines that end in a line feed. A line that the child did not finish is dropped.
std::vector<std::string> completeLines(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0, end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
        lines.push_back(text.substr(begin, end - begin));
    return lines;
}

// Runs the check `what` in a child process and adds its findings. If the child hung or crashed, adds a
// problem.
void runProbeProcess(const std::string& what, const std::string& who, const DoctorOptions& options,
                     std::vector<Finding>& findings) {
    const ChildOutcome outcome =
        runProgram(programFile(), {"probe", what, std::to_string(options.patience.count())},
                   {.timeout = options.patience});
    const std::string step = parseProbeLines(completeLines(outcome.text), findings);
    if (!outcome.started)
        findings.push_back({what, FindingState::problem, "no process could be started to check " + who,
                            "close other programs and try again"});
    else if (!outcome.in_time)
        findings.push_back({what + " hangs", FindingState::problem,
                            fmt::format("{} did not answer within {:.3g} s, in: {}", who,
                                        double(options.patience.count()) * 1e-3, step),
                            "restart " + who + "; if that does not help, restart the computer"});
    else if (!step.empty())
        findings.push_back(
            {what + " crashes", FindingState::problem,
             fmt::format("{} ended the program{}, in: {}", who,
                         outcome.signal ? fmt::format(" with signal {}", *outcome.signal) : "", step),
             "reinstall " + who + " or install another version"});
}

void checkDevices(const haptics::DeviceOptions& options, std::vector<Finding>& findings) {
    const std::vector<haptics::FoundDevice> devices = haptics::findDevices(options);
    for (const haptics::FoundDevice& device : devices)
        findings.push_back({"haptic device",
                            device.problem.empty() ? FindingState::ok : FindingState::problem,
                            device.kind + " at " + device.place + ": " + device.what, device.problem});
    if (devices.empty())
        findings.push_back(
            {"haptic device", FindingState::warning, "none is plugged in",
             "plug one in (\"stylet devices\" lists the supported ones) or use the controllers "
             "with --device controllers"});
}

void checkRealTime(std::vector<Finding>& findings) {
    const RealTimeLimits limits = realTimeLimits();
    const auto add = [&](const char* what, const std::string& refused, const char* right) {
        findings.push_back(
            warnUnless(refused.empty(), what,
                       refused.empty() ? "granted" : "refused: " + refused + ": ticks may be late",
                       describeHowToAllow({right})));
    };
    add("real-time priority", limits.priority_refused, kPriorityRight);
    add("locked memory", limits.memory_refused, kMemoryRight);
    const std::string governor = firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
    if (governor.empty()) return;  // not available on this computer
    const bool slow = governor == "powersave" || governor == "conservative";
    findings.push_back(
        warnUnless(!slow, "processor's governor", governor,
                   "choose \"performance\" while training: cpupower frequency-set -g performance"));
}

void checkUdevRules(std::vector<Finding>& findings) {
    std::string missing;
    for (const char* rules : {"70-stylet-hidraw.rules", "70-stylet-usb.rules"}) {
        bool there = false;
        for (const char* folder :
             {"/etc/udev/rules.d/", "/run/udev/rules.d/", "/usr/lib/udev/rules.d/", "/lib/udev/rules.d/"})
            if (std::error_code none; std::filesystem::exists(std::string(folder) + rules, none))
                there = true;
        if (!there) missing += (missing.empty() ? "" : " and ") + std::string(rules);
    }
    findings.push_back(
        warnUnless(missing.empty(), "udev rules",
                   missing.empty() ? "installed" : missing + " not installed: devices may need root",
                   "copy packaging/udev/*.rules to /etc/udev/rules.d and plug the device in again"));
}

Finding checkFolder(const char* what, const std::filesystem::path& folder) {
    const FolderState state = folderState(folder);
    const std::string space =
        fmt::format("{}, {:.1f} GB free", folder.string(), double(state.free_bytes) * 1e-9);
    if (!state.refused.empty())
        return {what, FindingState::problem, folder.string() + ": " + state.refused,
                "make it writable for you, or set its XDG_ variable to another folder"};
    if (state.free_bytes < kLittleSpace)
        return {what, FindingState::warning, space,
                "free disk space: a patient and a day's records need two gigabytes"};
    return {what, FindingState::ok, space};
}

Finding checkData() {
    const Finding folder = checkFolder("data", dataFolder());
    if (folder.state == FindingState::problem || !isDataTemporary()) return folder;
    return {"data", FindingState::warning,
            folder.found + ", but temporary: attempts stored there will be lost",
            "set HOME, or set XDG_DATA_HOME to the absolute path of a permanent folder"};
}

void checkAssets(std::vector<Finding>& findings) {
    const char* const todo = "set STYLET_ASSETS to the assets folder, or unset it and reinstall Stylet";
    try {
        const std::filesystem::path folder = assetsFolder();
        std::string missing;
        for (const char* part : {"cases", "instruments", "looks", "rooms", "scenarios", "tissue/ptcd.toml",
                                 "ultrasound/tissues.toml"})
            if (std::error_code none; !std::filesystem::exists(folder / part, none))
                missing += (missing.empty() ? "" : ", ") + std::string(part);
        if (missing.empty())
            findings.push_back({"assets", FindingState::ok, folder.string()});
        else
            findings.push_back(
                {"assets", FindingState::problem, folder.string() + ": missing: " + missing, todo});
    } catch (const std::exception& e) {
        findings.push_back({"assets", FindingState::problem, e.what(), todo});
    }
}

// Reads each file that `chosen` accepts. Adds one finding for all readable files, and one for each unreadable
// file.
template <typename Chosen, typename Read>
void readAll(const char* what, const std::filesystem::path& folder, const char* todo, const Chosen& chosen,
             const Read& read, std::vector<Finding>& findings) {
    std::size_t files = 0, bad = 0;
    std::error_code error;
    auto entry = std::filesystem::recursive_directory_iterator(
        folder, std::filesystem::directory_options::skip_permission_denied, error);
    for (; !error && entry != std::filesystem::recursive_directory_iterator() && files < kMaxFiles;
         entry.increment(error)) {
        if (!chosen(entry->path())) continue;
        ++files;
        try {
            read(entry->path());
        } catch (const std::exception& e) {
            ++bad;
            findings.push_back({what, FindingState::problem, e.what(), todo});
        }
    }
    findings.push_back(
        {what, FindingState::ok, std::to_string(files - bad) + " in " + folder.string() + " can be read"});
}

void checkRecords(const std::filesystem::path& folder, std::vector<Finding>& findings) {
    if (folder.empty()) return;
    if (std::error_code none; !std::filesystem::is_directory(folder, none)) {
        findings.push_back({"records", FindingState::problem, folder.string() + " is not a folder",
                            "pass the folder of the attempts"});
        return;
    }
    readAll(
        "records", folder, "move this record elsewhere; it is damaged and cannot be replayed",
        [](const auto& path) { return path.filename() == "record.json"; },
        [](const auto& path) { records::loadRecord(path.parent_path()); }, findings);
}

void checkRegistrations(std::vector<Finding>& findings) {
    const std::filesystem::path folder = dataFolder() / "registrations";
    if (std::error_code none; !std::filesystem::is_directory(folder, none)) {
        findings.push_back({"registration", FindingState::warning,
                            "none: the device's place in the headset's room is unknown",
                            "connect headset and device and run \"stylet register\""});
        return;
    }
    readAll(
        "registration", folder, "run \"stylet register\" again",
        [](const auto& path) { return path.extension() == ".json"; },
        [](const auto& path) { loadRegistration(path); }, findings);
}

void checkDisplay(std::vector<Finding>& findings) {
    const std::string x = environment("DISPLAY"), wayland = environment("WAYLAND_DISPLAY");
    const bool any = !x.empty() || !wayland.empty();
    findings.push_back(
        warnUnless(any, "window",
                   any ? "on display " + (wayland.empty() ? x : wayland)
                       : "neither DISPLAY nor WAYLAND_DISPLAY is set: no window for the instructor",
                   "start it from a desktop session"));
}

}  // namespace

std::vector<Finding> examine(const DoctorOptions& options) noexcept {
    std::vector<Finding> findings;
    // Runs a check. An exception becomes a finding.
    const auto look = [&](const char* what, const auto& at) {
        try {
            at();
        } catch (const std::exception& e) {
            findings.push_back({what, FindingState::problem, e.what(), ""});
        }
    };
    look("runtime", [&] { runProbeProcess("runtime", "the OpenXR runtime", options, findings); });
    look("graphics", [&] { runProbeProcess("vulkan", "the graphics driver", options, findings); });
    look("haptic device", [&] { checkDevices(options.devices, findings); });
    look("udev rules", [&] { checkUdevRules(findings); });
    look("real-time priority", [&] { checkRealTime(findings); });
    look("assets", [&] { checkAssets(findings); });
    look("cache", [&] { findings.push_back(checkFolder("cache", cacheFolder())); });
    look("data", [&] { findings.push_back(checkData()); });
    look("records", [&] { checkRecords(options.records, findings); });
    look("registration", [&] { checkRegistrations(findings); });
    look("window", [&] { checkDisplay(findings); });
    return findings;
}

std::string parseProbeLines(const std::vector<std::string>& lines, std::vector<Finding>& findings) {
    std::string step = "starting";
    for (const std::string& text : lines) {
        const json line = json::parse(text, nullptr, false);
        if (!line.is_object()) continue;
        if (line.contains("about"))
            step = textIn(line, "about");
        else if (line.contains("state"))
            findings.push_back(parseFinding(line));
    }
    return step;
}

std::string describeFindings(const std::vector<Finding>& findings, bool as_json) {
    json list = json::array();
    std::string text;
    for (const Finding& f : findings) {
        list.push_back(findingJson(f));
        text += fmt::format("{:<8} {:<22} {}\n", enumName(kStates, f.state), f.what, f.found);
        if (!f.todo.empty()) text += fmt::format("{:9}-> {}\n", "", f.todo);
    }
    return as_json ? json{{"findings", list}}.dump(2, ' ', false, json::error_handler_t::replace) + "\n"
                   : text;
}

int doctor(const DoctorOptions& options) noexcept {
    const std::vector<Finding> findings = examine(options);
    std::fputs(describeFindings(findings, options.json).c_str(), stdout);
    const bool problems = std::any_of(findings.begin(), findings.end(),
                                      [](const Finding& f) { return f.state == FindingState::problem; });
    return problems ? 1 : 0;
}

int probe(const std::string& what, std::chrono::milliseconds patience) {
    const auto say = [](const json& line) {
        std::printf("%s\n", line.dump(-1, ' ', false, json::error_handler_t::replace).c_str());
        std::fflush(stdout);
    };
    const ProbeReport report{[&](const std::string& step) { say({{"about", step}}); },
                             [&](const Finding& finding) { say(findingJson(finding)); }};
    if (what == "runtime") probeRuntime(report, patience);
    if (what == "vulkan") probeVulkan(report);
    report.about("");  // all steps completed
    return 0;
}

}  // namespace stylet::trainer
