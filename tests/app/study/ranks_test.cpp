#include "app/study/ranks.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <stdexcept>

namespace stylet::study {
namespace {

TEST(Ranks, AloneWithoutMpirun) {
    const Ranks ranks;
    EXPECT_EQ(ranks.size(), 1);
    EXPECT_TRUE(ranks.first());
    ranks.wait();
    ranks.giveUp();
    setenv("SLURM_STEP_NUM_TASKS", "2", 1);  // srun without MPI: each task is its own rank 0
    EXPECT_THROW(Ranks(), std::runtime_error);
    unsetenv("SLURM_STEP_NUM_TASKS");
    if (Ranks::haveMpi()) return;  // study_run_test.cpp tests several ranks
    setenv("OMPI_COMM_WORLD_SIZE", "2", 1);
    EXPECT_THROW(Ranks(), std::runtime_error);
    unsetenv("OMPI_COMM_WORLD_SIZE");
}

// Every pair has exactly one leader, and each part of a pair belongs to another rank.
TEST(Ranks, EveryPairIsSomebodys) {
    for (const std::size_t pairs : {1u, 2u, 3u, 10u})
        for (const int size : {1, 2, 3, 4, 7, 25}) {
            std::set<std::pair<std::size_t, std::size_t>> parts;
            std::vector<std::size_t> wanted(pairs, 0);
            for (int rank = 0; rank < size; ++rank)
                for (const Share& share : sharesOf(rank, size, pairs)) {
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
    EXPECT_TRUE(sharesOf(0, 4, 0).empty());
}

}  // namespace
}  // namespace stylet::study
