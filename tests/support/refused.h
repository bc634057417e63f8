// Expects that a loader throws DataError that names the file and the field.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "patient/package/package.h"

namespace stylet::test {

template <typename Load>
void expectRefused(Load load, const std::string& file, const std::string& field) {
    try {
        load();
    } catch (const DataError& e) {
        EXPECT_NE(std::string(e.what()).find(file + ": " + field), std::string::npos) << e.what();
        return;
    }
    ADD_FAILURE() << file << " was taken, but " << field << " is bad";
}

}  // namespace stylet::test
