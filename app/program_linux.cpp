#include "app/program_linux.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <locale>

#include "base/errors.h"

namespace stylet {

namespace {

constexpr int kUsage = 100;

// open() returns the lowest free descriptor, and the lower standard streams are open by then.
void openStandardStreams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0 && errno == EBADF)
            open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY);
}

bool isPipeClosed() {
    pollfd out{STDOUT_FILENO, POLLOUT, 0};
    return poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

int exitStatus(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
    const auto failed = [&app](const std::exception& e, int status) {
        std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), e.what());
        return status;
    };
    try {
        app.parse(argc, argv);
        return work();
    } catch (const CLI::ParseError& e) {  // also --help
        return std::min(app.exit(e), kUsage);
    } catch (const UsageError& e) {
        return failed(e, kUsage);
    } catch (const EnvironmentError& e) {
        return failed(e, 3);
    } catch (const std::exception& e) {
        return failed(e, 2);
    }
}

}  // namespace

int runProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
    openStandardStreams();
    std::signal(SIGPIPE, SIG_IGN);
    std::locale::global(std::locale::classic());
    const int status = exitStatus(app, argc, argv, work);
    std::cout.flush();
    const bool flushed = std::fflush(stdout) == 0;
    if ((flushed && std::ferror(stdout) == 0 && std::cout) || isPipeClosed()) return status;
    std::fprintf(stderr, "%s: standard output: not all of it could be written\n", app.get_name().c_str());
    return status != 0 ? status : 2;
}

}  // namespace stylet
