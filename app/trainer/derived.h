// What is slow to compute and the same at every start, kept in the user's cache: it makes a start fast, and
// never decides what it finds. Each file carries a key of all that it was made of, this build of the program
// with it, and a hash of its bytes: one that is damaged, or of something else, is made anew. Several programs
// may share the folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "app/trainer/start.h"
#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::trainer {

// Of the files in a folder: the least lately used go.
struct DerivedLimits {
    std::size_t files = 12;
    std::uintmax_t bytes = std::uintmax_t(256) << 20;  // six touch maps of 1 mm
};

// Nothing where there is none, or one made of something else. Says on stderr that one is damaged. What is
// found counts as used now.
std::optional<std::vector<std::byte>> loadDerived(const std::filesystem::path& file, std::uint64_t key);
// Whole or not at all; says on stderr what the disk refused. The new file stays, whatever its size.
void saveDerived(const std::filesystem::path& file, std::uint64_t key, std::span<const std::byte> bytes,
                 const DerivedLimits& = {});

// `parts` with this build of the program. Nothing where it cannot be told from others: then nothing is kept.
std::optional<std::uint64_t> derivedKey(std::initializer_list<std::uint64_t> parts);

// What is pressed on: haptics::makeTouchMap, or what an earlier start kept of it in `folder`.
// One that is made is counted in `made`.
using MakeTouch = std::function<haptics::TouchMap(const patient::Patient&)>;
haptics::TouchMap keptTouchMap(const patient::Patient&, std::uint64_t patient_digest,
                               const std::filesystem::path& folder, Made* made = nullptr);

// A touch map as it is kept. Nothing where the bytes are none.
std::optional<haptics::TouchMap> touchMapIn(std::span<const std::byte>);
std::vector<std::byte> bytesOf(const haptics::TouchMap&);

}  // namespace stylet::trainer
