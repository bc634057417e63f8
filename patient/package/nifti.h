// A bounded reader and writer of single-file NIfTI-1 volumes (.nii, .nii.gz). Written by hand because the
// available C library is not hardened against malicious headers. Format: nifti1.h, Cox et al. 2004,
// nifti.nimh.nih.gov.
#pragma once

#include <filesystem>
#include <span>

#include "base/volume.h"

namespace stylet::patient {

// T is std::int16_t (values are rounded and range-checked) or std::uint8_t (values must be whole). Reads
// uint8, int16, uint16, int32, float32 and float64 in either byte order, with scl_slope and scl_inter.
// Axes must be parallel to the patient's: flips are undone, oblique or permuted volumes are rejected.
// Sizes are checked before anything is allocated. Throws DataError.
template <typename T>
Volume<T> readNifti(const std::filesystem::path& file);
// The same from memory, gzip or not; `file` is used in error messages only.
template <typename T>
Volume<T> parseNifti(const std::filesystem::path& file, std::span<const std::byte> bytes);

// Vector volumes: `components` numbers per voxel along NIfTI's fifth dimension. `voxels` holds all voxels
// of the first component, then all of the second. Every number is finite. Flipped axes are rejected
// because they would also have to flip the vectors.
Volume<float> readNiftiVectors(const std::filesystem::path& file, int components);
Volume<float> parseNiftiVectors(const std::filesystem::path& file, std::span<const std::byte> bytes,
                                int components);
void writeNiftiVectors(const std::filesystem::path& file, const Volume<float>&, int components);

// Writes a volume, compressed if the name ends in .gz. The same volume gives the same bytes. Sets sform and
// qform; units are mm.
template <typename T>
void writeNifti(const std::filesystem::path& file, const Volume<T>& volume);

}  // namespace stylet::patient
