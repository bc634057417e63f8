// Helpers of tests that give a loader bad text.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/refused.h"

namespace stylet::test {

// `cases`: pairs of a text and a part of the message with which load(text) must reject it.
template <typename Load>
void expectRefusals(const Load& load, const std::vector<std::pair<std::string, std::string>>& cases) {
    for (const auto& [text, part] : cases) {
        const std::string message = errorText([&] { load(text); });
        EXPECT_NE(message.find(part), std::string::npos) << part << " in " << message;
        EXPECT_NE(message, "") << part;
    }
}

// Returns `text` with the first `from` replaced by `to`. `text` must contain `from`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace stylet::test
