#include "app/trainer/setup/doctor.h"

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

namespace stylet::trainer {

using json = nlohmann::ordered_json;

namespace {

constexpr std::uintmax_t kLittleSpace = std::uintmax_t(2) << 30;  // space for a 1 mm patient and some records
constexpr std::size_t kMostFiles = 10000;
constexpr std::array<const char*, 3> kStates{"ok", "warning", "problem"};

json lineOf(const Finding& f) {
    return {{"what", f.what}, {"state", kStates[std::size_t(f.state)]}, {"found", f.found}, {"todo", f.todo}};
}

// Returns a text field; empty if it is missing or has another type. A driver may print lines of its own,
// even JSON.
std::string textIn(const json& line, const char* name) {
    const auto found = line.find(name);
    return found != line.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Finding findingOf(const json& line) {
    const auto at = std::find(kStates.begin(), kStates.end(), textIn(line, "state"));
    return {textIn(line, "what"), FindingState(std::min<std::ptrdiff_t>(at - kStates.begin(), 2)),
            textIn(line, "found"), textIn(line, "todo")};
}

// Lines that end in a line feed: a line that the child did not finish is dropped.
std::vector<std::string> completeLines(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0, end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
        lines.push_back(text.substr(begin, end - begin));
    return lines;
}

// Runs the check `what` in a child process and adds its findings. Adds a problem if the child hung or
// crashed.
void askChild(const std::string& what, const std::string& who, const DoctorOptions& options,
              std::vector<Finding>& findings) {
    const ChildOutcome outcome =
        runProgram(thisProgram(), {"probe", what, std::to_string(options.patience.count())},
                   {.patience = options.patience});
    const std::string step = takeProbeLines(completeLines(outcome.text), findings);
    std::array<char, 32> limit{};
    std::snprintf(limit.data(), limit.size(), "%.3g s", double(options.patience.count()) * 1e-3);
    if (!outcome.started)
        findings.push_back({what, FindingState::problem, "no process could be started to check " + who,
                            "close other programs and try again"});
    else if (!outcome.in_time)
        findings.push_back({what + " hangs", FindingState::problem,
                            who + " did not answer within " + limit.data() + ", in: " + step,
                            "restart " + who + "; if that does not help, restart the computer"});
    else if (!step.empty())
        findings.push_back({what + " crashes", FindingState::problem,
                            who + " ended the program" +
                                (outcome.signal ? " with signal " + std::to_string(*outcome.signal) : "") +
                                ", in: " + step,
                            "reinstall " + who + " or install another version"});
}

void lookAtDevices(const haptics::DeviceOptions& options, std::vector<Finding>& findings) {
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

void lookAtRealTime(std::vector<Finding>& findings) {
    const RealTimeLimits limits = realTimeLimits();
    const auto add = [&](const char* what, const std::string& refused, const char* right) {
        const bool granted = refused.empty();
        findings.push_back({what, granted ? FindingState::ok : FindingState::warning,
                            granted ? "granted" : "refused: " + refused + ": ticks may be late",
                            granted ? "" : howToAllow({right})});
    };
    add("real-time priority", limits.priority_refused, kPriorityRight);
    add("locked memory", limits.memory_refused, kMemoryRight);
    const std::string governor = firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
    if (governor.empty()) return;  // not available on this computer
    const bool slow = governor == "powersave" || governor == "conservative";
    findings.push_back(
        {"processor's governor", slow ? FindingState::warning : FindingState::ok, governor,
         slow ? "choose \"performance\" while training: cpupower frequency-set -g performance" : ""});
}

void lookAtRules(std::vector<Finding>& findings) {
    std::string missing;
    for (const char* rules : {"70-stylet-hidraw.rules", "70-stylet-usb.rules"}) {
        bool there = false;
        for (const char* folder :
             {"/etc/udev/rules.d/", "/run/udev/rules.d/", "/usr/lib/udev/rules.d/", "/lib/udev/rules.d/"})
            if (std::error_code none; std::filesystem::exists(std::string(folder) + rules, none))
                there = true;
        if (!there) missing += (missing.empty() ? "" : " and ") + std::string(rules);
    }
    findings.push_back({"udev rules", missing.empty() ? FindingState::ok : FindingState::warning,
                        missing.empty() ? "installed" : missing + " not installed: devices may need root",
                        missing.empty() ? ""
                                        : "copy packaging/udev/*.rules to /etc/udev/rules.d and plug the "
                                          "device in again"});
}

void lookAtFolder(const char* what, const std::filesystem::path& folder, std::vector<Finding>& findings) {
    const FolderState state = folderState(folder);
    std::array<char, 48> space{};
    std::snprintf(space.data(), space.size(), ", %.1f GB free", double(state.free_bytes) * 1e-9);
    if (!state.refused.empty())
        findings.push_back({what, FindingState::problem, folder.string() + ": " + state.refused,
                            "make it writable for you, or set its XDG_ variable to another folder"});
    else if (state.free_bytes < kLittleSpace)
        findings.push_back({what, FindingState::warning, folder.string() + space.data(),
                            "free disk space: a patient and a day's records need two gigabytes"});
    else
        findings.push_back({what, FindingState::ok, folder.string() + space.data()});
}

void lookAtAssets(std::vector<Finding>& findings) {
    try {
        findings.push_back({"assets", FindingState::ok, assetsFolder().string()});
    } catch (const std::exception& e) {
        findings.push_back({"assets", FindingState::problem, e.what(), "set STYLET_ASSETS to their folder"});
    }
}

// Reads each file accepted by `chosen`. Adds one finding for all readable files and one for each unreadable
// file.
template <typename Chosen, typename Read>
void readAll(const char* what, const std::filesystem::path& folder, const char* todo, const Chosen& chosen,
             const Read& read, std::vector<Finding>& findings) {
    std::size_t files = 0, bad = 0;
    std::error_code error;
    auto entry = std::filesystem::recursive_directory_iterator(
        folder, std::filesystem::directory_options::skip_permission_denied, error);
    for (; !error && entry != std::filesystem::recursive_directory_iterator() && files < kMostFiles;
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

void lookAtRecords(const std::filesystem::path& folder, std::vector<Finding>& findings) {
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

void lookAtRegistrations(std::vector<Finding>& findings) {
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

void lookAtDisplay(std::vector<Finding>& findings) {
    const std::string x = environment("DISPLAY"), wayland = environment("WAYLAND_DISPLAY");
    const bool any = !x.empty() || !wayland.empty();
    findings.push_back({"window", any ? FindingState::ok : FindingState::warning,
                        any ? "on display " + (wayland.empty() ? x : wayland)
                            : "neither DISPLAY nor WAYLAND_DISPLAY is set: no window for the instructor",
                        any ? "" : "start it from a desktop session"});
}

}  // namespace

std::vector<Finding> examine(const DoctorOptions& options) noexcept {
    std::vector<Finding> findings;
    // An exception becomes a finding.
    const auto look = [&](const char* what, const auto& at) {
        try {
            at();
        } catch (const std::exception& e) {
            findings.push_back({what, FindingState::problem, e.what(), ""});
        }
    };
    look("runtime", [&] { askChild("runtime", "the OpenXR runtime", options, findings); });
    look("graphics", [&] { askChild("vulkan", "the graphics driver", options, findings); });
    look("haptic device", [&] { lookAtDevices(options.devices, findings); });
    look("udev rules", [&] { lookAtRules(findings); });
    look("real-time priority", [&] { lookAtRealTime(findings); });
    look("assets", [&] { lookAtAssets(findings); });
    look("cache", [&] { lookAtFolder("cache", cacheFolder(), findings); });
    look("data", [&] { lookAtFolder("data", dataFolder(), findings); });
    look("records", [&] { lookAtRecords(options.records, findings); });
    look("registration", [&] { lookAtRegistrations(findings); });
    look("window", [&] { lookAtDisplay(findings); });
    return findings;
}

std::string takeProbeLines(const std::vector<std::string>& lines, std::vector<Finding>& findings) {
    std::string step = "starting";
    for (const std::string& text : lines) {
        const json line = json::parse(text, nullptr, false);
        if (!line.is_object()) continue;
        if (line.contains("about"))
            step = textIn(line, "about");
        else if (line.contains("state"))
            findings.push_back(findingOf(line));
    }
    return step;
}

std::string describeFindings(const std::vector<Finding>& findings, bool as_json) {
    json list = json::array();
    std::string text;
    for (const Finding& f : findings) {
        list.push_back(lineOf(f));
        std::array<char, 48> head{};
        std::snprintf(head.data(), head.size(), "%-8s %-22s ", kStates[std::size_t(f.state)], f.what.c_str());
        text += head.data() + f.found + "\n";
        if (!f.todo.empty()) text += std::string(9, ' ') + "-> " + f.todo + "\n";
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
                             [&](const Finding& finding) { say(lineOf(finding)); }};
    if (what == "runtime") probeRuntime(report, patience);
    if (what == "vulkan") probeVulkan(report);
    report.about("");  // completed
    return 0;
}

}  // namespace stylet::trainer
