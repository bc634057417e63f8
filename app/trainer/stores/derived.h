// Cache for derived data that is slow to compute and always the same for the same inputs. It saves time and
// never changes a result. Each file stores a hash of its bytes and a key of all its inputs, including this
// build of the program. A file that is damaged or has another key is rebuilt. Several programs may share the
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

#include "app/records/replay.h"
#include "app/trainer/stores/start.h"
#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::trainer {

// Limits per folder. The least recently used files are evicted.
struct DerivedLimits {
    std::size_t files = 12;
    std::uintmax_t bytes = std::uintmax_t(256) << 20;  // six touch maps of 1 mm
};

// Returns nothing if the file is missing, damaged or has another key. Reports damage on stderr. Marks a valid
// file as used now.
std::optional<std::vector<std::byte>> loadDerived(const std::filesystem::path& file, std::uint64_t key);
// Writes the file atomically. Reports disk errors on stderr. The new file is never evicted, even if it
// exceeds the limits.
void saveDerived(const std::filesystem::path& file, std::uint64_t key, std::span<const std::byte> bytes,
                 const DerivedLimits& = {});

// Hash of `parts` and this build of the program. Returns nothing if the build cannot be identified; in that
// case nothing is cached.
std::optional<std::uint64_t> derivedKey(std::initializer_list<std::uint64_t> parts);

using records::MakeTouch;

// Returns haptics::makeTouchMap(patient), from the cache in `folder` if possible. If it is computed, counts
// it in `made`.
haptics::TouchMap loadOrMakeTouchMap(const patient::Patient&, std::uint64_t patient_digest,
                                     const std::filesystem::path& folder, Made* made = nullptr);

// Serialisation of a touch map. parseTouchMap() returns nothing for invalid bytes.
std::optional<haptics::TouchMap> parseTouchMap(std::span<const std::byte>);
std::vector<std::byte> bytesOf(const haptics::TouchMap&);

}  // namespace stylet::trainer
