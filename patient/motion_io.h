// motion.nii.gz: the fields of a motion model, one vector of 13 float32 a node: wall a1 (x, y, z), wall a2,
// slide a1, slide a2, level. Metres, and metres per (1/s). Clamps, grid and reference breath stand in
// patient.toml, exactly.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "patient/motion.h"

namespace stylet::patient {

inline constexpr int kMotionComponents = 13;

// Fills fields and level of `model`, whose other members patient.toml has given. Throws DataError.
void readMotion(const std::filesystem::path& file, MotionModel& model);
// The same from memory, gzip or not; `file` is only named in refusals.
void parseMotion(const std::filesystem::path& file, std::span<const std::byte> bytes, MotionModel& model);
void writeMotion(const std::filesystem::path& file, const MotionModel&);

// What a flow of four midpoint steps needs: sizes that fit, finite values within 0.1 m and 1 m, fields that
// are zero on the outermost nodes and nowhere steeper over the clamped surrogate than the steps can follow.
// Throws DataError, in the name of `file`.
void checkMotion(const std::filesystem::path& file, const MotionModel&);

}  // namespace stylet::patient
