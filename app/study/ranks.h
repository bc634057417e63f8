// Several processes working on one study, on one or more machines that share OUT's file system. Uses MPI if
// it was built in and mpirun or srun started the program; otherwise this process works alone.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stylet::study {

class Ranks {
  public:
    // Joins the other ranks. From now on SIGTERM, which mpirun sends to every rank when one is lost, ends
    // the process with a message that says what to do. Throws EnvironmentError if there are other ranks
    // but MPI was not built in, or if MPI finds fewer ranks than were started. Each would do all the work
    // then.
    Ranks();
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    static bool hasMpi();

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool first() const { return rank_ == 0; }
    // Barrier: blocks until all ranks have called it. Waiting does not load the processor.
    void barrier() const;
    // Aborts all ranks. Returns if this process runs alone.
    void abort() const;

  private:
    int rank_ = 0, size_ = 1;
    [[maybe_unused]] bool joined_ = false;
};

// Assignment of a pair to a rank. With at least as many pairs as ranks, each pair has one rank. With fewer
// pairs, several ranks share a pair and take its blocks in turn.
struct Share {
    std::size_t pair = 0;
    std::size_t part = 0, parts = 1;  // this rank's index among the pair's ranks; 0 leads
};
std::vector<Share> assignShares(int rank, int size, std::size_t pairs);

}  // namespace stylet::study
