// Expects that a call throws a certain error.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/errors.h"

namespace stylet::test {

// The text of the error that a call throws. Empty if it throws none.
template <typename Error = DataError, typename Call>
std::string errorText(const Call& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

// Expects a DataError that names the file and the field.
template <typename Load>
void expectRefused(const Load& load, const std::string& file, const std::string& field) {
    const std::string text = errorText(load);
    EXPECT_NE(text.find(file + ": " + field), std::string::npos)
        << file << ": " << field << " was not refused: " << text;
}

}  // namespace stylet::test
