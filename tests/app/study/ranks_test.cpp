#include "app/study/ranks.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <stdexcept>

namespace stylet::study {
namespace {

TEST(Ranks, RunsAloneWithoutMpirun) {
    const Ranks ranks;
    EXPECT_EQ(ranks.size(), 1);
    EXPECT_TRUE(ranks.first());
    ranks.barrier();
    ranks.abort();
    setenv("SLURM_STEP_NUM_TASKS", "2", 1);  // srun without MPI: each task is its own rank 0
    EXPECT_THROW(Ranks(), std::runtime_error);
    unsetenv("SLURM_STEP_NUM_TASKS");
    if (Ranks::hasMpi()) return;  // study_run_test.cpp tests several ranks
    setenv("OMPI_COMM_WORLD_SIZE", "2", 1);
    EXPECT_THROW(Ranks(), std::runtime_error);
    unsetenv("OMPI_COMM_WORLD_SIZE");
}

// No part of a pair belongs to two ranks, and none is missing. Every pair therefore has exactly one leader:
// the rank with part 0.
TEST(Ranks, EveryPairIsAssigned) {
    for (const std::size_t pairs : {1u, 2u, 3u, 10u})
        for (const int size : {1, 2, 3, 4, 7, 25}) {
            std::set<std::pair<std::size_t, std::size_t>> parts;
            std::vector<std::size_t> wanted(pairs, 0);
            for (int rank = 0; rank < size; ++rank)
                for (const Share& share : assignShares(rank, size, pairs)) {
                    ASSERT_LT(share.pair, pairs);
                    ASSERT_LT(share.part, share.parts);
                    EXPECT_TRUE(parts.emplace(share.pair, share.part).second);
                    wanted[share.pair] = share.parts;
                }
            std::size_t all = 0;
            for (const std::size_t count : wanted) {
                EXPECT_GE(count, 1u);
                all += count;
            }
            EXPECT_EQ(parts.size(), all) << pairs << " pairs on " << size;
        }
    EXPECT_TRUE(assignShares(0, 4, 0).empty());
}

}  // namespace
}  // namespace stylet::study
