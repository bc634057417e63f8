// Several processes at one study, on one machine or many, which share OUT's file system: MPI where it was
// built in and mpirun or srun has started the program, else this process alone.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stylet::study {

class Ranks {
  public:
    // Joins the others. From now on SIGTERM, which mpirun sends to all when one is lost, ends the process
    // with a line that says what to do. Throws std::runtime_error where there are others and MPI was not
    // built in, or finds fewer than were started: each would do everything.
    Ranks();
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    static bool haveMpi();

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool first() const { return rank_ == 0; }
    // Until all ranks have come here; without load on the processor.
    void wait() const;
    // Ends all of them; returns where this process is alone.
    void giveUp() const;

  private:
    int rank_ = 0, size_ = 1;
    [[maybe_unused]] bool joined_ = false;
};

// Whose work a pair is. As many pairs as ranks or more: each pair has one rank. Fewer: several ranks share a
// pair and take its blocks in turns.
struct Share {
    std::size_t pair = 0;
    std::size_t part = 0, parts = 1;  // this rank's of the pair's ranks; 0 leads
};
std::vector<Share> sharesOf(int rank, int size, std::size_t pairs);

}  // namespace stylet::study
