// motion.nii.gz: the fields of a motion model, one vector of 13 float32 per node: wall a1 (x, y, z), wall
// a2, slide a1, slide a2, level. Units: metres, and metres per (1/s). patient.toml holds the clamping
// ranges, the grid's spacing and origin, and the reference breath.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "patient/motion/motion.h"

namespace stylet::patient {

inline constexpr int kMotionComponents = 13;

// Fills the fields and the level of `model`; its other members must already be set from patient.toml.
// Throws DataError.
void readMotion(const std::filesystem::path& file, MotionModel& model);
// The same from memory, gzip or not; `file` is used in error messages only.
void parseMotion(const std::filesystem::path& file, std::span<const std::byte> bytes, MotionModel& model);
void writeMotion(const std::filesystem::path& file, const MotionModel&);

// patient.toml contains the exact grid of each volume. Throws DataError if the grid in a volume's own header
// differs from it by more than single precision allows.
void checkStoredGrid(const std::filesystem::path& file, const Grid& own, const Grid& exact,
                     double origin_tolerance_m);

// Checks the conditions for a flow of four midpoint steps: sizes match; values are finite and within 0.1 m
// (fields) and 1 m (level); fields are zero on the outermost nodes; no field is steeper than the steps can
// follow over the clamped surrogate. Throws DataError that names `file`.
void checkMotion(const std::filesystem::path& file, const MotionModel&);

}  // namespace stylet::patient
