#include "app/study/ranks.h"

#include <cstdlib>
#include <stdexcept>

#ifdef STYLET_STUDY_MPI
#include <mpi.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>
#endif

namespace stylet::study {

namespace {

bool startedAsOneOfMany() {
    // Open MPI's mpirun, PMIx and PMI (srun).
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"})
        if (std::getenv(name)) return true;
    return false;
}

// Checks the size against the launcher's: if MPI is missing ranks, each process would do all the work.
void refuseUnlessOneOf(int size) {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
        if (const char* started = std::getenv(name); started && std::atoi(started) != size)
            throw std::runtime_error(std::string("started as one of ") + started + " (" + name +
                                     "), but MPI finds " + std::to_string(size) +
                                     ": start with mpirun, or srun --mpi=pmix");
}

}  // namespace

#ifdef STYLET_STUDY_MPI

namespace {

constexpr int kGaveUp = 2;

extern "C" void stopped(int) {
    static constexpr char kText[] =
        "stylet-study: stopped from outside, as all ranks are when one is lost: what is finished stays, the "
        "same command resumes from there\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kText, sizeof kText - 1);
    _exit(kGaveUp);
}

}  // namespace

bool Ranks::haveMpi() {
    return true;
}

Ranks::Ranks() {
    if (!startedAsOneOfMany()) {
        refuseUnlessOneOf(1);
        return;
    }
    int threads = 0;  // only this thread calls MPI
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &threads);
    joined_ = true;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    try {
        refuseUnlessOneOf(size_);
    } catch (...) {
        MPI_Finalize();  // the constructor throws, so the destructor will not run
        throw;
    }
    if (size_ > 1) std::signal(SIGTERM, stopped);
}

Ranks::~Ranks() {
    if (joined_) MPI_Finalize();
}

void Ranks::wait() const {
    if (size_ == 1) return;
    MPI_Request request;
    MPI_Ibarrier(MPI_COMM_WORLD, &request);
    for (int done = 0; !done;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

void Ranks::giveUp() const {
    if (size_ > 1) MPI_Abort(MPI_COMM_WORLD, kGaveUp);
}

#else

bool Ranks::haveMpi() {
    return false;
}

Ranks::Ranks() {
    if (startedAsOneOfMany())
        throw std::runtime_error("started as one of several ranks, but built without MPI (STYLET_MPI)");
    refuseUnlessOneOf(1);
}

Ranks::~Ranks() = default;
void Ranks::wait() const {}
void Ranks::giveUp() const {}

#endif

std::vector<Share> sharesOf(int rank, int size, std::size_t pairs) {
    std::vector<Share> shares;
    const auto r = std::size_t(rank), all = std::size_t(size);
    if (pairs == 0) return shares;
    if (all > pairs) return {{r % pairs, r / pairs, (all - 1 - r % pairs) / pairs + 1}};
    for (std::size_t pair = r; pair < pairs; pair += all)
        shares.push_back({pair, 0, 1});
    return shares;
}

}  // namespace stylet::study
