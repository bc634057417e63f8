#include "app/modeller/image/limited_child_linux.h"

#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "app/modeller/image/import_error.h"
#include "base/child_process_linux.h"
#include "base/errors.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxMessageChars = 1000;

// Returns the first line of the child's output, for display. Characters that are not printable ASCII become
// '?'. The length limit leaves room for the longest message, a list of DICOM series.
std::string sanitiseMessage(const std::string& message) {
    std::string out;
    for (char c : message) {
        if (c == '\n' || out.size() == kMaxMessageChars) break;
        out += c >= 32 && c < 127 ? c : '?';
    }
    return out;
}

std::string failureReason(const ChildOutcome& end, const ChildLimits& limits, const std::string& who) {
    if (!end.in_time) return fmt::format("{} was stopped after {} s", who, limits.wall_s);
    if (end.signal && (*end.signal == SIGXCPU || *end.signal == SIGKILL))
        return fmt::format("{} was stopped at its limit of {} s of work", who, limits.cpu_s);
    if (end.signal) return fmt::format("the file crashed {} ({})", who, strsignal(*end.signal));
    const std::string message = sanitiseMessage(end.text);
    return message.empty() ? who + " failed without a message" : message;
}

}  // namespace

PrivateFolder::PrivateFolder() {
    std::string name = (fs::temp_directory_path() / "stylet-import-XXXXXX").string();
    if (!mkdtemp(name.data())) throw EnvironmentError("no temporary folder can be made in " + name);
    path_ = name;
}

PrivateFolder::~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

fs::path childProgram(const fs::path& given, const std::string& name) {
    if (!given.empty()) {
        if (access(given.c_str(), X_OK) != 0)
            throw EnvironmentError(given.string() + ": the program is missing");
        return given;
    }
    // In a build tree, the child program is next to this program. When installed, it is in libexec.
    std::error_code error;
    const fs::path bin = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (const fs::path& program : {bin / name, bin.parent_path() / "libexec" / "stylet" / name})
        if (access(program.c_str(), X_OK) == 0) return program;
    throw EnvironmentError((bin / name).string() +
                           ": the program is missing (it is built with STYLET_ITK=ON)");
}

void runChild(const fs::path& program, const std::vector<std::string>& arguments, const ChildLimits& limits,
              const std::string& about, const std::string& who) {
    const ChildSettings settings{
        .timeout = std::chrono::seconds(limits.wall_s),
        .kill_timeout = std::chrono::minutes(1),
        .max_text_bytes = 2048,
        .limits = ResourceLimits{limits.cpu_s, limits.memory_bytes, limits.file_bytes},
    };
    const ChildOutcome end = runProgram(program, arguments, settings);
    if (!end.started) throw EnvironmentError(program.string() + " cannot be started");
    if (end.in_time && !end.status && !end.signal)
        throw EnvironmentError(program.string() + " ended without an exit status");
    if (end.status != 0 || !end.in_time) throw ImportError(about + ": " + failureReason(end, limits, who));
}

}  // namespace stylet::modeller
