// Cache for derived data that is slow to compute and the same at every start. It saves time and never
// changes a result. Each file stores a key of all its inputs, including this build of the program, and a
// hash of its bytes. A damaged file, or one with another key, is rebuilt. Several programs may share the
// folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "app/trainer/stores/start.h"
#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::trainer {

// Limits per folder. The least recently used files are evicted.
struct DerivedLimits {
    std::size_t files = 12;
    std::uintmax_t bytes = std::uintmax_t(256) << 20;  // six touch maps of 1 mm
};

// Returns nothing if the file is missing, damaged or has another key. Reports damage on stderr. A file that
// is found counts as used now.
std::optional<std::vector<std::byte>> loadDerived(const std::filesystem::path& file, std::uint64_t key);
// Writes the file atomically and reports disk errors on stderr. The new file is not evicted, whatever its
// size.
void saveDerived(const std::filesystem::path& file, std::uint64_t key, std::span<const std::byte> bytes,
                 const DerivedLimits& = {});

// Hash of `parts` and this build of the program. Returns nothing if the build cannot be identified; then
// nothing is cached.
std::optional<std::uint64_t> derivedKey(std::initializer_list<std::uint64_t> parts);

// Returns haptics::makeTouchMap(patient), from the cache in `folder` if possible. Counts a computed map in
// `made`.
using MakeTouch = std::function<haptics::TouchMap(const patient::Patient&)>;
haptics::TouchMap keptTouchMap(const patient::Patient&, std::uint64_t patient_digest,
                               const std::filesystem::path& folder, Made* made = nullptr);

// Serialisation of a touch map. touchMapIn() returns nothing for invalid bytes.
std::optional<haptics::TouchMap> touchMapIn(std::span<const std::byte>);
std::vector<std::byte> bytesOf(const haptics::TouchMap&);

}  // namespace stylet::trainer
