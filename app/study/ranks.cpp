#include "app/study/ranks.h"

#include <fmt/core.h>

#include <cstdlib>

#include "base/errors.h"

#ifdef STYLET_STUDY_MPI
#include <mpi.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>
#endif

namespace stylet::study {

namespace {

bool isStartedByLauncher() {
    // Open MPI's mpirun, PMIx and PMI (srun).
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"})
        if (std::getenv(name)) return true;
    return false;
}

// Checks the size against the launcher's: if MPI is missing ranks, each process would do all the work.
void checkLauncherSize(int size) {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
        if (const char* started = std::getenv(name); started && std::atoi(started) != size)
            throw EnvironmentError(fmt::format(
                "started as one of {} ({}), but MPI finds {}: start with mpirun, or srun --mpi=pmix", started,
                name, size));
}

}  // namespace

#ifdef STYLET_STUDY_MPI

namespace {

constexpr int kAbortStatus = 2;

extern "C" void onTerminate(int) {
    static constexpr char kText[] =
        "stylet-study: terminated (mpirun ends all ranks when one is lost). Finished blocks are kept; the "
        "same command resumes the study.\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kText, sizeof kText - 1);
    _exit(kAbortStatus);
}

}  // namespace

bool Ranks::hasMpi() {
    return true;
}

Ranks::Ranks() {
    if (!isStartedByLauncher()) {
        checkLauncherSize(1);
        return;
    }
    int threads = 0;  // only this thread calls MPI
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &threads);
    joined_ = true;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    try {
        checkLauncherSize(size_);
    } catch (...) {
        MPI_Finalize();  // the constructor throws, so the destructor will not run
        throw;
    }
    if (size_ > 1) std::signal(SIGTERM, onTerminate);
}

Ranks::~Ranks() {
    if (joined_) MPI_Finalize();
}

void Ranks::barrier() const {
    if (size_ == 1) return;
    MPI_Request request;
    MPI_Ibarrier(MPI_COMM_WORLD, &request);
    for (int done = 0; !done;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

void Ranks::abort() const {
    if (size_ > 1) MPI_Abort(MPI_COMM_WORLD, kAbortStatus);
}

#else

bool Ranks::hasMpi() {
    return false;
}

Ranks::Ranks() {
    if (isStartedByLauncher())
        throw EnvironmentError(
            "started as one of several ranks, but built without MPI: build with -DSTYLET_MPI=ON, or start "
            "one process");
    checkLauncherSize(1);
}

Ranks::~Ranks() = default;
void Ranks::barrier() const {}
void Ranks::abort() const {}

#endif

std::vector<Share> assignShares(int rank, int size, std::size_t pairs) {
    std::vector<Share> shares;
    const auto r = std::size_t(rank), all = std::size_t(size);
    if (pairs == 0) return shares;
    if (all > pairs) return {{r % pairs, r / pairs, (all - 1 - r % pairs) / pairs + 1}};
    for (std::size_t pair = r; pair < pairs; pair += all)
        shares.push_back({pair, 0, 1});
    return shares;
}

}  // namespace stylet::study
