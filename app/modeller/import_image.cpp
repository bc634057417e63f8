#include "app/modeller/import_image.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>
#include <thread>

#include "app/modeller/image_handover.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

// A folder that only this user can enter, gone when the import is done with it.
class PrivateFolder {
  public:
    PrivateFolder() {
        std::string name = (fs::temp_directory_path() / "stylet-import-XXXXXX").string();
        if (!mkdtemp(name.data())) throw ImportError("no temporary folder can be made in " + name);
        path_ = name;
    }
    ~PrivateFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    PrivateFolder(const PrivateFolder&) = delete;
    PrivateFolder& operator=(const PrivateFolder&) = delete;
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

void limit(decltype(RLIMIT_CPU) what, std::size_t value) {
    const rlimit r{value, value};
    setrlimit(what, &r);
}

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void becomeReader(const char* const* argv, int say, const ReaderLimits& limits) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limit(RLIMIT_AS, limits.memory_bytes);
    limit(RLIMIT_CPU, std::size_t(limits.cpu_s));
    limit(RLIMIT_FSIZE, std::size_t(kMaxImageVoxels) * 2 + 4096);
    limit(RLIMIT_NOFILE, 64);
    limit(RLIMIT_CORE, 0);
    const int quiet = open("/dev/null", O_RDWR);
    dup2(quiet, STDIN_FILENO);
    dup2(say, STDOUT_FILENO);
    dup2(quiet, STDERR_FILENO);
    execv(argv[0], const_cast<char* const*>(argv));
    _exit(127);
}

using Clock = std::chrono::steady_clock;

// Until it closes its output; false where the deadline comes first.
bool listen(int pipe, Clock::time_point deadline, std::string& said) {
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) return false;
        pollfd wait_for{pipe, POLLIN, 0};
        const int ready = poll(&wait_for, 1, int(left.count()));
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        if (ready < 0) return true;
        char text[512];
        const ssize_t n = read(pipe, text, sizeof text);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return true;
        if (said.size() < 2048) said.append(text, std::size_t(n));
    }
}

// Until it has ended; false where the deadline comes first.
bool ended(pid_t child, Clock::time_point deadline, int& status) {
    for (;;) {
        const pid_t who = waitpid(child, &status, WNOHANG);
        if (who == child) return true;
        if (who < 0 && errno != EINTR) throw ImportError("the image reader is lost");
        if (Clock::now() >= deadline) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

struct ChildEnd {
    int status = 0;
    bool timed_out = false;
    std::string said;
};

ChildEnd runReader(const char* const* argv, const ReaderLimits& limits) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw ImportError("no pipe to the image reader");
    const auto deadline = Clock::now() + std::chrono::seconds(limits.wall_s);
    const pid_t child = fork();
    if (child == 0) becomeReader(argv, ends[1], limits);
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        throw ImportError("the image reader cannot be started");
    }
    ChildEnd end;
    const bool silent = listen(ends[0], deadline, end.said);
    close(ends[0]);
    end.timed_out = !silent || !ended(child, deadline, end.status);
    if (end.timed_out) {
        kill(child, SIGKILL);
        while (waitpid(child, &end.status, 0) < 0 && errno == EINTR) {
        }
    }
    return end;
}

// What the child said is quoted to the user: one line, printable, short.
std::string tidy(const std::string& said) {
    std::string out;
    for (char c : said) {
        if (c == '\n' || out.size() == 400) break;
        out += c >= 32 && c < 127 ? c : '?';
    }
    return out;
}

std::string reasonOf(const ChildEnd& end, const ReaderLimits& limits) {
    if (end.timed_out) return "the reader was stopped after " + std::to_string(limits.wall_s) + " s";
    if (WIFSIGNALED(end.status)) {
        if (WTERMSIG(end.status) == SIGXCPU || WTERMSIG(end.status) == SIGKILL)
            return "the reader was stopped at its limit of " + std::to_string(limits.cpu_s) + " s of work";
        return std::string("the file crashed the reader (") + strsignal(WTERMSIG(end.status)) + ")";
    }
    const std::string said = tidy(end.said);
    return said.empty() ? "the reader gave up without a word" : said;
}

// The child read a hostile file: nothing it hands over is trusted. What is not a file could block its
// opening.
patient::Volume<std::int16_t> takeOver(const fs::path& file, const fs::path& source, ImageKind kind) {
    std::ifstream in;
    ImageHandover h;
    const auto bad = [&](const std::string& why) {
        return ImportError(source.string() + ": the reader returned " + why);
    };
    if (!fs::is_regular_file(fs::symlink_status(file))) throw bad("no image");
    in.open(file, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(&h), sizeof h) || h.magic != kHandoverMagic) throw bad("no image");
    std::int64_t count = 1;
    for (int d = 0; d < 3; ++d) {
        const auto i = std::size_t(d);
        if (h.dims[i] < 1 || h.dims[i] > kMaxImageSide) throw bad("an image of impossible size");
        if (!(h.spacing_mm[i] >= 0.05 && h.spacing_mm[i] <= 20.0) || !(std::fabs(h.origin_mm[i]) < 1e5))
            throw bad("an image of impossible scale");
        count *= h.dims[i];
    }
    if (count > kMaxImageVoxels || fs::file_size(file) != sizeof h + std::uintmax_t(count) * 2)
        throw bad("an image cut short");
    patient::Grid grid;
    for (int d = 0; d < 3; ++d) {
        grid.dims[d] = int(h.dims[std::size_t(d)]);
        grid.spacing_m[d] = h.spacing_mm[std::size_t(d)] * 1e-3;
        grid.origin_m[d] = h.origin_mm[std::size_t(d)] * 1e-3;
    }
    patient::Volume<std::int16_t> image(grid);
    if (!in.read(reinterpret_cast<char*>(image.voxels.data()), std::streamsize(count * 2)))
        throw bad("too little");
    if (kind == ImageKind::labels) {
        const auto lowest = std::min_element(image.voxels.begin(), image.voxels.end());
        if (*lowest < 0) throw bad("a label of " + std::to_string(*lowest) + ", which is below 0");
    }
    return image;
}

}  // namespace

patient::Volume<std::int16_t> readImage(const fs::path& path, ImageKind kind, const ReaderLimits& limits) {
    std::error_code error;
    if (!fs::exists(path, error)) throw ImportError(path.string() + ": there is no such file or folder");
    if (kind == ImageKind::labels && fs::is_directory(path, error))
        throw ImportError(path.string() + ": is a folder; labels are one NIfTI file");
    fs::path program = limits.program;
    if (program.empty())
        program = fs::read_symlink("/proc/self/exe", error).parent_path() / "stylet-image-reader";
    if (access(program.c_str(), X_OK) != 0)
        throw ImportError(program.string() +
                          ": the image reader is missing (it is built with STYLET_ITK=ON)");

    const PrivateFolder folder;
    const std::string exe = program.string(), source = path.string(),
                      out = (folder.path() / "image").string();
    const char* const argv[] = {exe.c_str(), kind == ImageKind::ct ? "ct" : "labels", source.c_str(),
                                out.c_str(), nullptr};
    const ChildEnd end = runReader(argv, limits);
    if (end.timed_out || !WIFEXITED(end.status) || WEXITSTATUS(end.status) != 0)
        throw ImportError(source + ": " + reasonOf(end, limits));
    return takeOver(out, path, kind);
}

}  // namespace stylet::modeller
