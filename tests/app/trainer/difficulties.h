// The shipped difficulties.
#pragma once

#include "app/training/difficulty.h"
#include "tests/app/trainer/assets.h"

namespace stylet::test {

inline const training::DifficultyTable& difficulties() {
    static const training::DifficultyTable table = training::loadDifficulties(assets() / "difficulty.toml");
    return table;
}

}  // namespace stylet::test
