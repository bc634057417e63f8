#include "app/program_linux.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <locale>

namespace stylet {

namespace {

// open() returns the lowest free descriptor, and the lower standard streams are open by then.
void openStandardStreams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0 && errno == EBADF)
            open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY);
}

bool nobodyReads() {
    pollfd out{STDOUT_FILENO, POLLOUT, 0};
    return poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

}  // namespace

int runProgram(const char* name, int (*program)(int, char**), int argc, char** argv) {
    openStandardStreams();
    std::signal(SIGPIPE, SIG_IGN);
    std::locale::global(std::locale::classic());
    const int status = program(argc, argv);
    std::cout.flush();
    const bool flushed = std::fflush(stdout) == 0;
    if ((flushed && std::ferror(stdout) == 0 && std::cout) || nobodyReads()) return status;
    std::fprintf(stderr, "%s: standard output: not all of it could be written\n", name);
    return status != 0 ? status : 2;
}

}  // namespace stylet
