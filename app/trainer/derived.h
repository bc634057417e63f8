// What is slow to compute and the same at every start, kept in the user's cache: it makes a start fast, and
// never decides what it finds. Each file carries a key of all that it was made of, this build of the program
// with it, and a hash of its bytes: one that is damaged, or of something else, is made anew.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::trainer {

inline constexpr std::size_t kMostDerived = 12;  // files in a folder; the oldest go

// Nothing where there is none, or one made of something else. Says on stderr that one is damaged.
std::optional<std::vector<std::byte>> loadDerived(const std::filesystem::path& file, std::uint64_t key);
// Whole or not at all; says on stderr what the disk refused.
void saveDerived(const std::filesystem::path& file, std::uint64_t key, std::span<const std::byte> bytes);

// `parts` with this build of the program. Nothing where it cannot be told from others: then nothing is kept.
std::optional<std::uint64_t> derivedKey(std::initializer_list<std::uint64_t> parts);

// What is pressed on: haptics::makeTouchMap, or what an earlier start kept of it in `folder`.
using MakeTouch = std::function<haptics::TouchMap(const patient::Patient&)>;
haptics::TouchMap keptTouchMap(const patient::Patient&, std::uint64_t patient_digest,
                               const std::filesystem::path& folder);

}  // namespace stylet::trainer
