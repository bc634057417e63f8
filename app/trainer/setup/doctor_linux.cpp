#include "app/trainer/setup/doctor_linux.h"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <thread>

#include "app/trainer/stores/platform_linux.h"
#include "base/folder_linux.h"
#include "base/whole_file.h"

namespace stylet::trainer {

RealTimeLimits realTimeLimits() {
    RealTimeLimits limits;
    std::thread([&] {
        sched_param parameter{};
        parameter.sched_priority = kRealTimePriority;
        if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter))
            limits.priority_refused = std::strerror(error);
    }).join();
    if (mlockall(MCL_CURRENT) != 0)
        limits.memory_refused = std::strerror(errno);
    else
        munlockall();
    return limits;
}

FolderState folderState(const std::filesystem::path& folder) {
    FolderState state;
    try {
        requireFolder(folder, "folder");
        state.free_bytes = std::filesystem::space(folder).available;
        const std::filesystem::path file = folder / (".doctor-" + std::to_string(getpid()));
        writeWholeFile(file, "x");
        std::error_code gone;
        std::filesystem::remove(file, gone);
    } catch (const std::exception& e) {
        state.refused = e.what();
    }
    return state;
}

std::string firstLine(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    return line;
}

}  // namespace stylet::trainer
